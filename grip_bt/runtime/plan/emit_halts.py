"""Source of the stops of nodes: what sets whole sub-trees to INVALID, before they are ticked again or on leaving."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import groupby

from py_trees.common import Status

from .emit_ours import emit_halt, emit_report
from .kinds import Kind
from .parts import Inside, Part
from .writer import Writer

Outer = tuple[Callable[[], Status], Callable[[], None]]

LOOP = 3
"""So many leaves of one class in a row are ticked in a loop."""

UNFOLDED = 2
"""So many levels of inner nodes are stopped in place; deeper ones by functions of their own."""


class HaltEmitter:
    """Writes what stops nodes.

    Attributes:
        write: what was written.
        functions: the source of functions that stop inner nodes.
        resets: ids of inner nodes that their parents may stop -> the variables that tell so; false at first.

    Args:
        inline: tells whether a child is written into its parent's source.
        outer: returns what ticks and what halts a child that isn't.
    """

    def __init__(self, inline: Callable[[Part], bool], outer: Callable[[Part], Outer]):
        self.write = Writer()
        self.functions: list[str] = []
        self.resets: dict[int, str] = {}
        self._halting: dict[int, str] = {}
        self._inline, self._outer = inline, outer

    def _halts(self, inside: Inside, i: str, write: Writer, unless: str = "is not I") -> None:
        """Write what stops the children whose status `is not I`, or whichever."""
        at = 0
        for run in runs_of(inside.kids, self._inline):
            if len(run) >= LOOP:
                with write.block(f"for n in {self.write.bind(f'L{i}_{at}', [kid.node for kid in run])}:"):
                    if inside.ours:
                        with write.block(f"if n.status {unless}:"):
                            emit_halt(write, "n")
                    else:
                        write(f"if n.status {unless}: n.status = I")
            else:
                name = self.write.bind(f"n{i}_{at}", run[0].node)
                with write.block(f"if {name}.status {unless}:"):
                    self._halt(run[0], name, f"{i}_{at}", write)
            at += len(run)

    def _halt(self, part: Part, name: str, i: str, write: Writer) -> None:
        """Write what stops one node, with all below it."""
        inside = part.inside
        if inside is None or not self._inline(part):
            write(f"{self.write.bind(f'h{i}', self._outer(part)[1])}()")
        elif inside.ours and not _quiet(part):
            write(f"{self.write.bind(f'h{i}', part.halt)}()")
        elif inside.ours and inside.kind is Kind.LEAF:
            emit_halt(write, name)
        elif inside.kind is Kind.LEAF:
            write(*([f"{name}.terminate(I)"] if inside.terminates else []), f"{name}.status = I")
        elif inside.kind in (Kind.SEQUENCE, Kind.SELECTOR) and i.count("_") <= UNFOLDED:
            self._halt_composite(inside, name, i, write)
            if write is self.write:
                write(f"{self._reset(part)} = True")
        else:
            write(f"{self.halting(part, inside)}()")

    def _halt_composite(self, inside: Inside, name: str, i: str, write: Writer) -> None:
        if inside.ours:
            write(f"{name}.outcome = {name}.failure = None")
        write(f"{name}.current_child = None")
        self._halts(inside, i, write)
        if inside.ours:
            write(f"{name}.status = I")
            emit_report(write, name)
            return
        write(*([f"{name}.terminate(I)"] if inside.terminates else []), f"{name}.status = I")

    def halting(self, part: Part, inside: Inside) -> str:
        """Write a function that stops an inner node with all below it, once; return its name."""
        function = self._halting.get(id(part.node))
        if function is not None:
            return function
        self._halting[id(part.node)] = function = f"q{len(self._halting)}"
        name = self.write.bind(f"{function}n", part.node)
        body = Writer()
        if inside.ours and not _quiet(part):
            body(f"{self.write.bind(f'{function}h', part.halt)}()")
        elif inside.kind is Kind.DECORATOR:
            if inside.terminates:
                body(f"{name}.terminate(I)")
            kid = self.write.bind(f"n{function}_0", inside.kids[0].node)
            self._halt(inside.kids[0], kid, f"{function}_0", body)
            with body.block(f"if {kid}.status is R:"):
                self._halt(inside.kids[0], kid, f"{function}_0", body)
            body(f"{name}.status = I")
        else:
            if inside.kind is Kind.PARALLEL:
                self._halts(inside, function, body, "is R")
            self._halt_composite(inside, name, function, body)
        self.functions += [f"def {function}():", *body.lines]
        return function

    def _reset(self, part: Part) -> str:
        """Return the name of the variable that tells whether the children were found or made INVALID in this tick."""
        return self.resets.setdefault(id(part.node), f"z{len(self.resets)}")


def _quiet(part: Part) -> bool:
    """Tell whether stopping a node of ours calls nobody but observers: leaves and composites without `terminate`."""
    inside = part.inside
    if inside is None or inside.terminates or part.relink is not None:
        return False
    return inside.kind in (Kind.LEAF, Kind.SEQUENCE, Kind.SELECTOR) and all(map(_quiet, inside.kids))


def _simple(part: Part) -> bool:
    inside = part.inside
    return inside is not None and inside.kind is Kind.LEAF and not inside.terminates


def runs_of(kids: tuple[Part, ...], inline: Callable[[Part], bool]) -> Iterator[list[Part]]:
    """Yield children one by one, and leaves of one class in a row that override `update` alone together."""

    def bare(kid: Part) -> type | None:
        plain = _simple(kid) and not kid.inside.initialises and inline(kid)  # type: ignore[union-attr]
        return type(kid.node) if plain else None

    for cls, group in groupby(kids, bare):
        run = list(group)
        if cls is not None and len(run) >= LOOP:
            yield run
        else:
            yield from ([kid] for kid in run)
