"""From compiled nodes to generated source: which sub-trees share a function, and what makes the function run.

A sub-tree of at most `REGION` nodes is written into one function, with its guard in front: what the source relies on is
compared once a tick, when the function stops or ticks the sub-tree. Where something differs, the closure of the same
node ticks instead.
"""

from __future__ import annotations

import marshal
import threading
from collections.abc import Callable
from dataclasses import replace
from types import CodeType
from typing import Any

from py_trees.common import Status

from .emit import Emitter
from .emit_halts import Outer
from .kinds import Kind
from .parts import Inside, Part
from .watch import Methods
from .writer import Writer

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
        clock: holds one object, another one in each tick.
    """

    def __init__(self, outdated: Callable[[], None], clock: list[int]):
        self._outdated, self._clock = outdated, clock
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
        ticking = list(emitter.write.lines)
        halting = Writer()
        emitter.halt(part, halting)
        names = emitter.write.names
        names["refused"], names["refused_halt"] = self._refusing(part.tick), self._refusing(part.halt)
        names["clock"] = self._clock
        guard = _guard(emitter.insides, emitter, names)
        flags = ["checked", *emitter.flags()]
        lines = [
            f"def make({', '.join(names)}):",
            f"{' = '.join(flags)} = None",
            *emitter.functions,
            "def tick(S=S, F=F, R=R, I=I):",
            f" nonlocal {', '.join(flags)}",
            " now = clock[0]",
            " if checked is not now:",
            f"  if {guard}: return refused()",
            "  checked = now",
            *ticking,
            " return s",
            "def halt(R=R, I=I):",
            f" nonlocal {', '.join(flags)}",
            " now = clock[0]",
            " if checked is not now:",
            f"  if {guard}: return refused_halt()",
            "  checked = now",
            *halting.lines,
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


def _guard(parts: list[Part], emitter: Emitter, names: dict[str, Any]) -> str:
    """Return an expression that is true where the nodes aren't as they were; bind its names."""
    checks = []
    insides = [_inside(part) for part in parts]
    methods = Methods.joined(inside.methods for inside in insides)
    if methods.dicts:
        names.update(watched=methods.dicts, sizes=methods.sizes, replaced=methods.replaced)
        checks.append("([*map(len, watched)] != sizes and replaced())")
    for part, inside in zip(parts, insides, strict=True):
        name = emitter.name(part.node)
        if inside.kind is Kind.DECORATOR:
            checks.append(f"{name}.decorated is not {emitter.name(inside.kids[0].node)}")
            continue
        checks.append(f"{name}.children != {emitter.kids(inside, name[1:])}")
        if inside.kind in (Kind.SEQUENCE, Kind.SELECTOR):
            names[f"m{name}"] = inside.memory
            checks.append(f"{name}.memory is not m{name}")
    return " or ".join(checks)


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
