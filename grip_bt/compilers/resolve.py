"""The front end of both compilers: a task with every name resolved, or everything that keeps it from being compiled."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from grip_bt.base.errors import InvalidTaskError
from grip_bt.base.issue import Issue
from grip_bt.task.catalog import Catalog, Manifest, check_value, manifest_of_task, parse_type
from grip_bt.task.exploration import Labels
from grip_bt.task.model import (
    AnyNode,
    Container,
    Leaf,
    StateMachine,
    Subtask,
    Task,
    Variable,
    children_of,
    default_outcome,
    join,
    outcomes_of,
    type_of,
    with_refusal,
)
from grip_bt.task.parts import Edges
from grip_bt.task.validation import structural_issues
from grip_bt.task.validation.analysis import type_or_none

from .scopes import Scope, Scopes

_NO_EDGES = Edges()


@dataclass(eq=False)
class Part:
    """One node of a task, resolved; nobody changes it.

    Attributes:
        name: its key; the task's name for the root.
        meaning: each of its outcomes -> success or failure.
        declares: whether `scope` is its own.
        exits: ends of children -> its outcomes.
        edges: of a state machine: ends of children -> siblings or its outcomes.
        manifest: of a leaf; what a subtask looks like from outside.
        outside: the variables around a subtask, whose own scope sees none of them.
    """

    name: str
    path: str
    node: AnyNode
    meaning: Mapping[str, str]
    scope: Scope
    declares: bool
    children: tuple[Part, ...] = ()
    exits: Edges = _NO_EDGES
    edges: Edges = _NO_EDGES
    manifest: Manifest | None = None
    outside: Scope | None = None

    @property
    def around(self) -> Scope:
        if self.outside is not None:
            return self.outside
        return self.scope.outer if self.declares and self.scope.outer is not None else self.scope

    @cached_property
    def labels(self) -> Labels:
        """With what the children may end, and where that leads."""
        return Labels({child.name: list(child.meaning.items()) for child in self.children}, self.exits, self.edges)

    def walk(self) -> Iterator[Part]:
        stack = [self]
        while stack:
            part = stack.pop()
            yield part
            stack.extend(reversed(part.children))


@dataclass(frozen=True)
class Resolved:
    """A task that can be compiled.

    Attributes:
        ends: (``"/"``, root's outcome, code) -> outcome of the task.
    """

    task: Task
    root: Part
    scopes: Scopes
    ends: Edges

    def end(self, outcome: str, code: str | None) -> tuple[str, str]:
        label = self.ends.target("/", outcome, code)
        if label is None:
            raise LookupError(f"the root ended with {outcome!r}, which leads to no outcome of the task")
        return label, self.task.outcomes[label]


def resolve(task: Task, catalog: Catalog, data: Mapping[str, object] | None = None) -> Resolved:
    """Resolve every name of a task.

    Args:
        data: values that replace the initial values of the task's own variables.

    Raises:
        InvalidTaskError: with all problems that were found.
    """
    values = dict(data or {})
    issues = [*structural_issues(task, catalog), *_wrong_values(task.variables, values)]
    if issues:
        raise InvalidTaskError(issues, task.name)
    work = _Resolver(catalog)
    outer = work.scopes.declare(Scopes.TASK, task.variables, None)
    for name, value in values.items():
        outer.cells[name].preset(value)
    root = work.part(task.name, "/", task.root, outer)
    return Resolved(task, root, work.scopes, Edges.of_children({"/": _ends(task, root)}))


def _wrong_values(declared: Mapping[str, Variable | str], values: Mapping[str, object]) -> Iterator[Issue]:
    for name, value in values.items():
        if name not in declared:
            message = f"the task declares no variable {name!r} (available: {', '.join(declared) or 'none'})"
            yield Issue("/", "undeclared-variable", "error", message)
            continue
        type_ = type_or_none(type_of(declared[name]))
        if type_ is not None and (wrong := check_value(type_, value)) is not None:
            yield Issue("", "wrong-initial-value", "error", f"variable {name!r} is {type_}: {wrong}")


def _ends(task: Task, root: Part) -> dict[str, str]:
    """Return where the ends of a task's root lead; what `on:` doesn't map keeps its label, or goes by its meaning."""
    on = {
        outcome: target
        for outcome, meaning in root.meaning.items()
        if (target := default_outcome(task, outcome, meaning)) is not None
    }
    return {**on, **task.root.on}


class _Resolver:
    def __init__(self, catalog: Catalog):
        self.catalog = catalog
        self.scopes = Scopes()

    def part(self, name: str, path: str, node: AnyNode, outer: Scope) -> Part:
        if isinstance(node, Leaf):
            return self.leaf(name, path, node, outer)
        if isinstance(node, Subtask):
            return self.subtask(name, path, node, outer)
        scope = self.scopes.declare(path, _variables(node, outer), outer)
        above, below = join(path, ""), children_of(node)
        children = tuple([self.part(child, above + child, inner, scope) for child, inner in below.items()])
        exits = edges = _NO_EDGES
        if isinstance(node, StateMachine):
            edges = Edges.of_children({child: inner.on for child, inner in below.items()})
        elif node.exits:
            exits = Edges.of_exits(node.exits)
        return Part(name, path, node, outcomes_of(node), scope, scope is not outer, children, exits, edges)

    def leaf(self, name: str, path: str, node: Leaf, scope: Scope) -> Part:
        manifest = self.catalog.get(node.node)
        meaning: Mapping[str, str] = manifest.outcomes
        if node.precondition or node.meaning:
            meaning = with_refusal(node, manifest.outcomes_for(dict(node.meaning)))
        return Part(name, path, node, meaning, scope, False, manifest=manifest)

    def subtask(self, name: str, path: str, node: Subtask, outside: Scope) -> Part:
        """Return a subtask with the root of its file as its child, each end of which is an exit."""
        task = self.catalog.tasks.read(node.task)
        face = manifest_of_task(node.task, task)
        meaning = with_refusal(node, face.outcomes_for(dict(node.meaning)))
        scope = self.scopes.declare(path, task.variables, None)
        root = self.part(task.name, f"{path}/", task.root, scope)
        exits = Edges.of_children({root.name: _ends(task, root)})
        return Part(name, path, node, meaning, scope, True, (root,), exits, manifest=face, outside=outside)


def _variables(node: Container, outer: Scope) -> Mapping[str, Variable | str]:
    declared: dict[str, Variable | str] = dict(node.data)
    for _, items, item in node.taken():
        cell = outer.find(items)
        held = type_of(declared[items]) if items in declared else cell.type if cell is not None else "Any"
        declared[item] = str(parse_type(held).item or "Any")
    return declared
