"""Sequences and fallbacks with memory -> state machines: one machine per composite, children under their names."""

from __future__ import annotations

from grip_bt.base.errors import listing
from grip_bt.base.frozen import FrozenDict
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Fallback, Leaf, Parallel, Sequence, StateMachine, Subtask, Task

from ..machine_table import interrupts, lead
from ..resolve import Part, resolve
from .result import Built, Note, Restructured, common, is_within, kept, paths_of, successors


def to_state_machines(task: Task, catalog: Catalog, approximate: bool = False, within: str = "/") -> Restructured:
    """Return the task with every sequence and fallback that has an equal state machine as that machine.

    Paths stay as they are. Outcomes stay too: a machine declares `success` and `failure`, which its composite had
    without saying so.

    Args:
        task: the document.
        catalog: where the leaves' manifests are.
        approximate: let a reactive composite become the machine of one with memory, which isn't the same: it doesn't
            look at its first child again while a later one runs. Each is noted.
        within: only this node and those in it are converted.

    Raises:
        InvalidTaskError: the task is wrong; it holds everything that was found.
    """
    work = _Work(approximate, within)
    root = work.convert(resolve(task, catalog).root, None)
    return Restructured(task.model_copy(update={"root": root.node}), paths_of(root), tuple(work.notes))


_APPROXIMATED = "it was reactive: as a machine it doesn't ask its first child again while a later one runs"


class _Work:
    def __init__(self, approximate: bool, within: str) -> None:
        self.within = within
        self.notes: list[Note] = []
        self.approximate = approximate

    def convert(self, part: Part, ticker: Part | None) -> Built:
        """Return a node in its new form; `ticker` is the container above that may interrupt it, if there is one."""
        if isinstance(part.node, Leaf | Subtask):
            return Built(part.node, {part.path: ()})
        if not is_within(part.path, self.within):
            inner = part if interrupts(part) else ticker
            return kept(part, {child.name: self.convert(child, inner) for child in part.children})
        ordered = isinstance(part.node, Sequence | Fallback)
        reactive = ordered and not getattr(part.node, "memory", True)
        rough = reactive and self.approximate and bool(part.children)
        reason = (None if rough else _why_not(part, ticker)) if ordered else _by_kind(part)
        if rough:
            self.notes.append(Note(part.path, part.node.kind, _APPROXIMATED, approximated=True))
        if reason:
            self.notes.append(Note(part.path, part.node.kind, reason, by_design=not ordered))
        inner = part if interrupts(part) and not rough else ticker
        same = kept(part, {child.name: self.convert(child, inner) for child in part.children})
        return same if reason is not None or not ordered else Built(_machine(part, same), same.places)


def _by_kind(part: Part) -> str | None:
    if isinstance(part.node, StateMachine):
        return None
    if isinstance(part.node, Parallel):
        return "its children run at once, and a state machine has one active child"
    return "a decorator is about the child that it holds, not about an order"


def _why_not(part: Part, ticker: Part | None) -> str | None:
    """Return why a sequence or fallback has no equal state machine, or None."""
    if not part.children:
        return "it has no children, and a state machine needs a first one"
    if not getattr(part.node, "memory", True):
        return "it is reactive: it asks its first child again while a later one runs"
    if ticker is not None and successors(part):
        return ticked_by(ticker)
    ambiguous = {child.name for child in part.children} & set(part.meaning)
    led_to = {target for row in _rows(part).values() for target in row.values()}
    if ambiguous & led_to:
        names = listing(repr(name) for name in sorted(ambiguous & led_to))
        return f"an edge to {names} could mean a child as well as an outcome; rename the child"
    return None


def ticked_by(ticker: Part) -> str:
    """Return why the inside of a container that looks at every tick keeps its form."""
    assert not isinstance(ticker.node, Leaf), "leaves interrupt nothing"
    return (
        f"it runs in {ticker.path} ({ticker.node.kind}), which may interrupt it at any tick, and a state machine takes"
        " one transition a tick where a composite continues at once"
    )


def _rows(part: Part) -> dict[str, dict[str, str]]:
    """Return child -> label of its end -> where it leads; codes before their outcome."""
    rows = {}
    for index, child in enumerate(part.children):
        row = {}
        for outcome in child.meaning:
            for code in (*sorted(part.exits.codes(child.name, outcome)), None):
                way = lead(part, index, outcome, code)
                label = outcome if code is None else f"{outcome}.{code}"
                row[label] = str(way.to or way.end)
        rows[child.name] = row
    return rows


def _machine(part: Part, same: Built) -> StateMachine:
    node = same.node
    assert isinstance(node, Sequence | Fallback), "only these have an order"
    children = {}
    for name, row in _rows(part).items():
        children[name] = node.children[name].model_copy(update={"on": FrozenDict(row)})
    return StateMachine(
        **common(node),
        kind="state_machine",
        outcomes=FrozenDict(part.meaning),
        initial=part.children[0].name,
        children=FrozenDict(children),
    )
