"""From compiled nodes to generated source: which sub-trees share a function, and what makes the function run.

A sub-tree of at most `REGION` nodes is written into one function, with its guard in front: what the source relies on is
compared in a few passes of C. Where something differs, the closure of the same node ticks instead.
"""

from __future__ import annotations

import marshal
import threading
from collections.abc import Callable
from dataclasses import replace
from operator import attrgetter
from types import CodeType
from typing import Any

from py_trees.common import Status

from .emit import Emitter, Outer
from .kinds import Kind
from .parts import Inside, Part
from .watch import Methods

REGION = 200
"""Nodes in one function, leaves that are children of its root apart."""

DEPTH = 8
"""Nodes inside one another in one function."""

Tick = Callable[[], Status]

Classes = tuple[type, ...]

_texts: dict[str, bytes] = {}
_codes: dict[tuple[str, Classes], CodeType] = {}
_lock = threading.Lock()
_LIMIT = 4096


def code_of(text: str, classes: Classes) -> CodeType:
    """Compile, or find what was compiled before: trees of the same shape have the same text.

    Code is shared by nodes of the same classes only: the interpreter specialises it for the classes that it meets.
    """
    code = _codes.get((text, classes))
    if code is None:
        compiled = _texts.get(text) or marshal.dumps(compile(text, "<plan>", "exec"))
        code = marshal.loads(compiled)
        with _lock:
            if len(_codes) >= _LIMIT:
                _codes.clear()
                _texts.clear()
            _texts[text], _codes[text, classes] = compiled, code
    return code


class Regions:
    """Generates the functions of one compiled tree.

    Args:
        outdated: called when a function finds that the tree has changed.
    """

    def __init__(self, outdated: Callable[[], None]):
        self._outdated = outdated
        self._sizes: dict[int, tuple[int, int]] = {}
        self._made: dict[int, Outer] = {}

    def tick(self, part: Part) -> Tick:
        """Return what ticks a compiled node: generated, where that can be."""
        for below in _children_first(part):
            self._measure(below)
        for below in _children_first(part):
            if below is not part and not self._small(below) and below.inside and below.inside.kids:
                self._generate(below)  # before who calls it, so that no call of this goes deep
        return self._generate(part)[0]

    def _generate(self, part: Part) -> Outer:
        """Return what ticks and what halts a node."""
        made = self._made.get(id(part))
        if made is None:
            if part.relink is not None and part.inside is not None:
                kids = [replace(kid, tick=self._generate(kid)[0]) for kid in part.inside.kids]
                made = part.relink(kids), part.halt
            elif not _writable(part) or _inside(part).kind is Kind.LEAF:
                made = part.tick, part.halt
            else:
                emitter = Emitter(lambda kid: self._inline(part, kid), self._generate)
                emitter.node(part)
                made = self._link(part, emitter)
            self._made[id(part)] = made
        return made

    def _inline(self, root: Part, part: Part) -> bool:
        return part is root or (_writable(part) and (self._sizes[id(part)][0] == 1 or self._small(root)))

    def _small(self, part: Part) -> bool:
        """Tell whether a whole sub-tree goes into one function."""
        size, height = self._sizes[id(part)]
        return size <= REGION and height <= DEPTH

    def _measure(self, part: Part) -> None:
        """Note the number of nodes below and including this one, and its height; those below are known."""
        below = [self._sizes[id(kid)] for kid in part.inside.kids] if part.inside else []
        self._sizes[id(part)] = 1 + sum(n for n, _ in below), 1 + max((height for _, height in below), default=0)

    def _link(self, part: Part, emitter: Emitter) -> Outer:
        halting = emitter.halting(part, _inside(part))
        names = emitter.write.names
        names["refused"], names["refused_halt"] = self._refusing(part.tick), self._refusing(part.halt)
        guard = _guard(emitter.insides, names) or "False"
        resets = " = ".join(emitter.resets.values())
        lines = [
            f"def make({', '.join(names)}):",
            *emitter.functions,
            "def tick(S=S, F=F, R=R, I=I):",
            f" if {guard}: return refused()",
            *([f" {resets} = False"] if resets else []),
            *emitter.write.lines,
            " return s",
            "def halt():",
            f" if {guard}: refused_halt()",
            f" else: {halting}()",
            "return tick, halt",
        ]
        text = "\n ".join(lines)
        made: dict[str, Any] = {}
        exec(code_of(text, emitter.classes()), made)
        return made["make"](**names)  # type: ignore[no-any-return]

    def _refusing(self, closure: Callable[[], Any]) -> Callable[[], Any]:
        """Return what is called where the tree has changed: the closure of the node, which looks for itself."""

        def refused() -> Any:
            self._outdated()
            return closure()

        return refused


def _guard(parts: list[Part], names: dict[str, Any]) -> str:
    """Return an expression that is true where the nodes aren't as they were; bind its names."""
    checks = []
    insides = [_inside(part) for part in parts]
    methods = Methods.joined(inside.methods for inside in insides)
    if methods.dicts:
        names.update(watched=methods.dicts, sizes=methods.sizes, replaced=methods.replaced)
        checks.append("([*map(len, watched)] != sizes and replaced())")
    for attribute in ("children", "memory", "decorated"):
        pairs = [
            (part.node, _expected(attribute, inside))
            for part, inside in zip(parts, insides, strict=True)
            if attribute == _watched(attribute, inside.kind)
        ]
        if len(pairs) == 1:
            names[f"{attribute}_of"], names[f"{attribute}_was"] = pairs[0]
            checks.append(f"{attribute}_of.{attribute} != {attribute}_was")
        elif pairs:
            names[f"{attribute}_of"] = [node for node, _ in pairs]
            names[f"{attribute}_was"] = [was for _, was in pairs]
            names[f"get_{attribute}"] = attrgetter(attribute)
            checks.append(f"[*map(get_{attribute}, {attribute}_of)] != {attribute}_was")
    return " or ".join(checks)


def _watched(attribute: str, kind: Kind) -> str | None:
    if kind is Kind.DECORATOR:
        return "decorated" if attribute == "decorated" else None
    if attribute == "memory":
        return "memory" if kind in (Kind.SEQUENCE, Kind.SELECTOR) else None
    return "children" if attribute == "children" else None


def _expected(attribute: str, inside: Inside) -> Any:
    if attribute == "memory":
        return inside.memory
    kids = [kid.node for kid in inside.kids]
    return kids if attribute == "children" else kids[0]


def _children_first(part: Part) -> list[Part]:
    """Return all below and including `part`, without going deep."""
    found, todo = [], [part]
    while todo:
        part = todo.pop()
        found.append(part)
        if part.inside is not None:
            todo += part.inside.kids
    return found[::-1]


def _inside(part: Part) -> Inside:
    assert part.inside is not None
    return part.inside


def _writable(part: Part) -> bool:
    """Tell whether source can be generated for a node: its rules can be written, and a leaf or not without children."""
    inside = part.inside
    return inside is not None and part.relink is None and (inside.kind is Kind.LEAF or bool(inside.kids))
