"""Source of the stops of nodes: what sets whole sub-trees to INVALID, before they are ticked again or on leaving.

A function of its own stops the children of one node, with what is below them in its place. It notes at which tick
that was (`z`), so that a child which is then ticked in the same one doesn't look at its own children again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import groupby
from typing import Any

from py_trees.common import Status

from .emit_ours import emit_halt, emit_report
from .kinds import Kind
from .parts import Inside, Part
from .writer import Writer

Outer = tuple[Callable[[], Status], Callable[[], None]]

LOOP = 3
"""So many leaves of ours of one class in a row are ticked in a loop."""

ROW = 16
"""So many leaves of py_trees in a row are written out one by one; longer rows are of one class and ticked in a loop."""

UNFOLDED = 2
"""So many levels of inner nodes are stopped in place; deeper ones by functions of their own."""

RESTARTING = (Kind.SEQUENCE, Kind.PARALLEL)
"""Kinds that stop their children before they tick them again."""

COMPOSITES = (Kind.SEQUENCE, Kind.SELECTOR, Kind.PARALLEL)


class HaltEmitter:
    """Writes what stops nodes.

    Attributes:
        write: what was written.
        functions: the source of functions that stop the children of inner nodes, and of the flags that they set.

    Args:
        inline: tells whether a child is written into its parent's source.
        outer: returns what ticks and what halts a child that isn't.
    """

    def __init__(self, inline: Callable[[Part], bool], outer: Callable[[Part], Outer]):
        self.write = Writer()
        self.functions: list[str] = []
        self._names: dict[int, str] = {}
        self._sweeps: dict[int, str] = {}
        self._flags: dict[int, str] = {}
        self._noted: list[str] = []
        self._inline, self._outer = inline, outer

    def name(self, node: Any) -> str:
        """Return the name that stands for a node everywhere in the source."""
        name = self._names.get(id(node))
        if name is None:
            name = self._names[id(node)] = self.write.bind(f"n{len(self._names)}", node)
        return name

    def flags(self) -> list[str]:
        """Return the names of the variables that tell at which tick the children of a node were stopped."""
        return list(self._flags.values())

    def sweep(self, part: Part, inside: Inside) -> str:
        """Write a function that stops the children of a node which aren't INVALID, once; return its name."""
        function = self._sweeps.get(id(part.node))
        if function is None:
            self._sweeps[id(part.node)] = function = f"q{len(self._sweeps)}"
            body, outside, self._noted = Writer(), self._noted, []
            self._halt_kids(inside, body, 0)
            nonlocals = [f" nonlocal {', '.join(self._noted)}"] if self._noted else []
            self.functions += [f"def {function}(now, R=R, I=I):", *nonlocals, *body.lines]
            self._noted = outside
        return function

    def halt(self, part: Part, write: Writer, depth: int = 0) -> None:
        """Write what stops one node, with all below it."""
        inside, node = part.inside, part.node
        if inside is None or not self._inline(part):
            write(f"{self.write.bind(f'h{self.name(node)}', self._outer(part)[1])}()")
        elif inside.ours and not _quiet(part):
            write(f"{self.write.bind(f'h{self.name(node)}', part.halt)}()")
        elif inside.kind is Kind.LEAF:
            self._halt_leaf(inside, self.name(node), write)
        elif inside.kind in COMPOSITES:
            self._halt_composite(part, inside, write, depth)
        else:
            self._halt_decorator(part, inside, write, depth)

    def _halt_leaf(self, inside: Inside, name: str, write: Writer) -> None:
        if inside.ours:
            emit_halt(write, name)
        elif _clears(inside):
            write(f'{name}.feedback_message = ""', f"{name}.status = I")
        else:
            write(*([f"{name}.terminate(I)"] if inside.terminates else []), f"{name}.status = I")

    def _halt_composite(self, part: Part, inside: Inside, write: Writer, depth: int) -> None:
        name = self.name(part.node)
        if inside.ours:
            write(f"{name}.outcome = {name}.failure = None")
        if inside.kind is Kind.PARALLEL and not self._calm(part):
            self._halt_kids(inside, write, depth + 1, "is R")
        write(f"{name}.current_child = None")
        if depth < UNFOLDED:
            self._halt_kids(inside, write, depth + 1)
        else:
            write(f"{self.sweep(part, inside)}(now)")
        if inside.terminates and not inside.ours:
            write(f"{name}.terminate(I)")
        write(f"{name}.status = I")
        if inside.ours:
            emit_report(write, name)
        if inside.kind in RESTARTING:
            flag = self.flag(part.node)
            self._noted.append(flag)
            write(f"{flag} = now")

    def _halt_decorator(self, part: Part, inside: Inside, write: Writer, depth: int) -> None:
        name, kid = self.name(part.node), inside.kids[0]
        if inside.terminates:
            write(f"{name}.terminate(I)")
        if self._calm(kid):
            self.halt(kid, write, depth + 1)
        else:
            stop = self.write.bind(f"h{self.name(kid.node)}", kid.halt if self._inline(kid) else self._outer(kid)[1])
            write(f"{stop}()", f"if {self.name(kid.node)}.status is R: {stop}()")
        write(f"{name}.status = I")

    def _halt_kids(self, inside: Inside, write: Writer, depth: int, unless: str = "is not I") -> None:
        """Write what stops the children whose status `is not I`, or whichever."""
        for run in rows_of(inside.kids, self._inline):
            if len(run) > 1 and (inside.ours or len(run) > ROW):
                with write.block(f"for n in {self.row(run)}:"):
                    if inside.ours:
                        with write.block(f"if n.status {unless}:"):
                            emit_halt(write, "n")
                    else:
                        write("n.status = I" if unless == "is not I" else f"if n.status {unless}: n.status = I")
            elif unless == "is not I" and self._simple(run[0]):
                write("".join(f"{self.name(kid.node)}.status = " for kid in run) + "I")
            else:
                for kid in run:
                    with write.block(f"if {self.name(kid.node)}.status {unless}:"):
                        self.halt(kid, write, depth)

    def row(self, run: list[Part]) -> str:
        """Return the name of a list of leaves."""
        return self.write.bind(f"L{self.name(run[0].node)}", [kid.node for kid in run])

    def flag(self, node: Any) -> str:
        """Return the name of the variable that tells at which tick the children were found or made INVALID."""
        return self._flags.setdefault(id(node), f"z{len(self._flags)}")

    def _simple(self, part: Part) -> bool:
        """Tell whether stopping a node is nothing but a new status."""
        return self._inline(part) and _leaf_of_theirs(part)

    def _calm(self, part: Part) -> bool:
        """Tell whether nobody is called when a node of py_trees is stopped with all below it."""
        inside = part.inside
        if inside is None or inside.ours or not self._inline(part) or (inside.terminates and not _clears(inside)):
            return False
        return all(map(self._calm, inside.kids))


def _clears(inside: Inside) -> bool:
    return inside.builtin is not None and inside.builtin.clears


def _leaf_of_theirs(part: Part) -> bool:
    inside = part.inside
    return inside is not None and inside.kind is Kind.LEAF and not inside.terminates and not inside.ours


def _quiet(part: Part) -> bool:
    """Tell whether stopping a node of ours calls nobody but observers: leaves and composites without `terminate`."""
    inside = part.inside
    if inside is None or inside.terminates or part.relink is not None:
        return False
    return inside.kind in (Kind.LEAF, Kind.SEQUENCE, Kind.SELECTOR) and all(map(_quiet, inside.kids))


def rows_of(kids: tuple[Part, ...], inline: Callable[[Part], bool]) -> Iterator[list[Part]]:
    """Yield children one by one, but leaves in a row that override `update` alone together.

    Leaves of ours of one class make a row, and so do many of py_trees of one class, or at most `ROW` of any.
    """

    def bare(kid: Part) -> tuple[bool, type | None]:
        inside = kid.inside
        if inside is None or inside.kind is not Kind.LEAF or not inline(kid):
            return False, None
        if inside.terminates or inside.initialises or inside.builtin is not None:
            return False, None
        return inside.ours, type(kid.node)

    waiting: list[Part] = []
    for (own, cls), group in groupby(kids, bare):
        run = list(group)
        if waiting and (own or cls is None or len(waiting) + len(run) > ROW):
            yield waiting
            waiting = []
        if cls is not None and not own:
            waiting += run
        elif own and len(run) >= LOOP:
            yield run
        else:
            yield from ([kid] for kid in run)
    if waiting:
        yield waiting
