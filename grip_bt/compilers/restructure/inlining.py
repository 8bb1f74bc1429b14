"""When it makes a difference that values go in and out of a subtask at once, and not one by one.

A part of a task reads and writes the variables around it while it runs. As a subtask it gets its inputs on entry and
hands out its outputs when it ends, and nothing at all when it is halted. Nobody can tell, unless something may halt it
or runs beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import count
from typing import Any

from grip_bt.base.errors import EditError, HandoverError, SubtaskError, listing
from grip_bt.base.expression import parse_expression
from grip_bt.task.canonical import file_data
from grip_bt.task.catalog import Catalog, manifest_of_task
from grip_bt.task.edit import Inline, Patch, RenameVariable, apply, title_of
from grip_bt.task.edit.editing import Edit, slot
from grip_bt.task.edit.steps import Assign
from grip_bt.task.model import (
    Childless,
    Kind,
    Leaf,
    Subtask,
    Task,
    Variable,
    type_of,
    walk,
)
from grip_bt.task.validation.analysis import PlacedNode, TaskAnalysis


def expect_nobody_can_tell(placed: PlacedNode, reads: set[str], writes: set[str]) -> None:
    """Refuse values that go in and out at another moment where something around a node could notice.

    Args:
        placed: the node.
        reads: variables around it that it reads.
        writes: variables around it that it writes.

    Raises:
        HandoverError: it could; the message names what, and where.
    """
    fix = "take all of that container, or say `approximate: true`"
    for around, inside in _interrupting(placed):
        kind = around.node.kind  # type: ignore[union-attr]
        if writes:
            raise HandoverError(
                placed.path,
                f"it writes {listing(sorted(writes))}, and the {kind} {around.path} may halt it, after which a subtask "
                f"hands nothing out; {fix}",
            )
        beside = 0
        for child in around.children.values():
            beside |= 0 if child is inside else child.writes
        changed = [name for name in sorted(reads) if name in placed.around and placed.around[name].bit & beside]
        if changed:
            raise HandoverError(
                placed.path,
                f"it reads {listing(changed)}, which another child of the {kind} {around.path} may write while it runs,"
                f" and a subtask gets its inputs on entry; {fix}",
            )


def _interrupting(placed: PlacedNode) -> Iterator[tuple[PlacedNode, PlacedNode]]:
    """Yield the containers above a node that may halt it or run something beside it, with their child above it."""
    inside, around = placed, placed.parent
    while around is not None:
        node = around.node
        if isinstance(node, Kind) and (node.concurrent or not node.blocking):
            yield around, inside
        inside, around = around, around.parent


def inlined(command: Inline, task: Task, catalog: Catalog) -> Patch:
    """Return the edit that puts what is in a subtask's file where the subtask is.

    A port that is bound is the variable that it is bound to; every other variable of the file is declared in the
    container that comes, under a fresh name where its name is taken.

    Args:
        command: which subtask.
        task: the task.
        catalog: the nodes that exist, and the files of the project.

    Raises:
        EditError: there is no such subtask, its file can't be read, or the result would do something else.
    """
    analysis = TaskAnalysis(task, catalog)
    placed = next((placed for placed in analysis.nodes if placed.path == command.path), None)
    if placed is None or not isinstance(placed.node, Subtask):
        raise EditError(command.path, "there is no subtask")
    try:
        inside = catalog.tasks.read(placed.node.task)
    except SubtaskError as error:
        raise EditError(command.path, str(error)) from None
    _expect_same_ends(placed, placed.node, inside)
    work = _Merging(placed, placed.node, inside, catalog)
    work.check()
    if not command.approximate:
        bound = work.bound()
        written = {bound[name] for name in placed.node.out}
        expect_nobody_can_tell(placed, set(placed.node.in_.values()), written)
    moving = Edit(task)
    record = work.record()
    if placed.parent is None:
        return Patch(title=title_of(command), steps=(Assign(at=(), key="root", value=record),))
    parent, name, container = moving.parent(command.path, "")
    at = (*moving.place(parent), slot(container))
    return Patch(title=title_of(command), steps=(Assign(at=at, key=name, value=record),))


def _expect_same_ends(placed: PlacedNode, node: Subtask, inside: Task) -> None:
    """Refuse a file whose outcomes aren't those of its root: what is around the subtask speaks of them."""
    if any(label != target for label, target in inside.root.on.items()):
        raise EditError(
            placed.path, f"{node.task} has outcomes of its own (`on` of its root); let them be the root's own"
        )
    if node.meaning:
        raise EditError(placed.path, "its `meaning` differs from the file's; change it there")


class _Merging:
    """The variables of a file among those of the task that runs it."""

    def __init__(self, placed: PlacedNode, node: Subtask, inside: Task, catalog: Catalog):
        self.placed, self.node, self.inside, self.catalog = placed, node, inside, catalog
        self.analysis = TaskAnalysis(inside, catalog)

    def bound(self) -> dict[str, str]:
        """Return each port that is bound -> the variable around the subtask."""
        return {**self.node.in_, **self.node.out}

    def check(self) -> None:
        """Refuse what can't be said with shared variables."""
        node, path = self.node, self.placed.path
        face = manifest_of_task(node.task, self.inside)
        root = self.analysis.root
        if {label: face.outcomes.get(label) for label in root.outcomes} != dict(root.outcomes) or (
            face.outcomes.keys() - root.outcomes.keys()
        ):
            raise EditError(path, f"{node.task} has other outcomes than its root; let them be the same")
        for port, variable in node.in_.items():
            written = bool(self.analysis.task_scope[port].bit & root.writes)
            if port in node.out and node.out[port] != variable:
                raise EditError(path, f"{port!r} goes in from {variable!r} and out to {node.out[port]!r}; bind one")
            if written and port not in node.out:
                raise EditError(path, f"{port!r} is written inside, which {variable!r} mustn't notice; copy it first")
        for port in node.out:
            if _has_value(self.inside.variables[port]) and port not in node.in_:
                raise EditError(path, f"the output {port!r} begins with a value of its own; remove that in {node.task}")
            if port in node.with_:
                raise EditError(path, f"{port!r} begins with a literal and is handed out; bind a variable")
        names = list(self.bound().values())
        if len(set(names)) < len(names):
            raise EditError(path, "two ports are bound to one variable; bind each to its own")
        self._check_scopes()

    def _check_scopes(self) -> None:
        own = self.own()
        if own and isinstance(self.inside.root, Childless):
            raise EditError(
                self.placed.path, f"the root of {self.node.task} can't declare variables; wrap it there first"
            )
        said = self.inside.root.precondition
        if said and set(parse_expression(said).names) & own.keys():
            raise EditError(
                self.placed.path, f"the precondition in {self.node.task} reads variables of its own; use a guard"
            )

    def own(self) -> dict[str, Any]:
        """Return the declarations of the variables that aren't shared with the task around."""
        bound, found = self.bound(), {}
        for name, declared in self.inside.variables.items():
            if name in bound:
                continue
            found[name] = file_data(declared)
            if name in self.node.with_:
                found[name] = {"type": type_of(declared), "value": file_data(self.node.with_[name])}
        return found

    def record(self) -> dict[str, Any]:
        """Return the node that takes the place of the subtask."""
        bound = self.bound()
        own = self.own()
        taken = {*self.placed.around, *_declared(self.inside)}
        to = {name: name if name not in self.placed.around else _fresh(name, taken) for name in own}
        renamed = _renamed(self.inside, {**bound, **to}, self.placed.path)
        root: dict[str, Any] = file_data(renamed.root)
        root.pop("on", None)
        if own:
            root["data"] = {**{to[name]: said for name, said in own.items()}, **root.get("data", {})}
        conditions = [said for said in (self.node.precondition, root.pop("precondition", "")) if said]
        if conditions:
            root["precondition"] = " and ".join(f"({c})" for c in conditions) if len(conditions) > 1 else conditions[0]
        if self.node.on:
            root["on"] = file_data(self.node.on)
        for key, value in self.node.x.items():
            root.setdefault(key, file_data(value))
        doc = root.get("doc") or self.node.doc or self.inside.doc
        if doc:
            root["doc"] = doc
        return root


def _has_value(declared: Variable | str) -> bool:
    return isinstance(declared, Variable) and declared.has_value


def _declared(task: Task) -> Iterator[str]:
    yield from task.variables
    for _, node in walk(task.root):
        if not isinstance(node, Leaf):
            yield from (*node.data, *(item for _, _, item in node.taken()))


def _fresh(name: str, taken: Iterable[str]) -> str:
    there = set(taken)
    return next(each for number in count(2) if (each := f"{name}_{number}") not in there)


def _renamed(task: Task, names: dict[str, str], path: str) -> Task:
    """Return a task whose variables have other names; by names that nobody has, since they may swap."""
    changed = {old: new for old, new in names.items() if old != new}
    try:
        for number, old in enumerate(changed):
            task = apply(task, RenameVariable(path="", name=old, to=f"passing_{number}")).task
        for number, new in enumerate(changed.values()):
            task = apply(task, RenameVariable(path="", name=f"passing_{number}", to=new)).task
    except EditError as error:
        raise EditError(path, f"in its file: {error}") from None
    return task
