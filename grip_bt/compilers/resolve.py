"""The front end of both compilers: a task with every name resolved, or all problems at once.

Only what a compiler can't do without is looked at here; `grip_bt.task.validation` says more, earlier and with fixes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from grip_bt.base.errors import GripError, InvalidTaskError, SubtaskError
from grip_bt.base.issue import Issue
from grip_bt.compilers.checks import check_expressions
from grip_bt.task.catalog import Catalog, Manifest, check_value, manifest_of_task, parse_type
from grip_bt.task.edges import Edges
from grip_bt.task.model import (
    AnyNode,
    Container,
    Foreign,
    Leaf,
    Parallel,
    StateMachine,
    Subtask,
    Switch,
    Task,
    Variable,
    type_of,
)
from grip_bt.task.validation.parts import not_listed
from grip_bt.task.walking import children_of, join, outcomes_of, with_refusal

from .checks import check_edges, check_leaf, check_ports, check_root, check_rules, problem
from .scopes import Cell, Scope, Scopes

_NO_EDGES = Edges()


@dataclass(slots=True, eq=False)
class Part:
    """One node of a task, resolved; nobody changes it.

    Attributes:
        name: its key; the task's name for the root.
        path: its path.
        node: what the document says.
        meaning: each of its outcomes -> success or failure.
        scope: the variables that it sees.
        declares: whether `scope` is its own.
        children: its children, in order.
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
        """The variables around the node, without its own."""
        if self.outside is not None:
            return self.outside
        return self.scope.outer if self.declares and self.scope.outer is not None else self.scope

    def walk(self) -> Iterator[Part]:
        """Yield this part and all below it, parents first."""
        stack = [self]
        while stack:
            part = stack.pop()
            yield part
            stack.extend(reversed(part.children))


@dataclass(frozen=True)
class Resolved:
    """A task that can be compiled.

    Attributes:
        task: the document.
        root: its root.
        scopes: its variables.
        ends: (``"/"``, root's outcome, code) -> outcome of the task.
    """

    task: Task
    root: Part
    scopes: Scopes
    ends: Edges

    def end(self, outcome: str, code: str | None) -> tuple[str, str]:
        """Return the task's outcome for an end of the root, and its meaning."""
        label = self.ends.target("/", outcome, code)
        if label is None:
            raise LookupError(f"the root ended with {outcome!r}, which leads to no outcome of the task")
        return label, self.task.outcomes[label]


def resolve(task: Task, catalog: Catalog, data: Mapping[str, Any] | None = None) -> Resolved:
    """Resolve every name of a task.

    Args:
        task: the document.
        catalog: where the leaves' manifests are.
        data: values that replace the initial values of the task's own variables.

    Raises:
        InvalidTaskError: with all problems that were found.
    """
    work = _Resolver(catalog)
    outer = work.declare(Scopes.TASK, task.variables, None)
    for name, value in (data or {}).items():
        if name in outer.cells:
            work.preset(outer.cells[name], value)
        else:
            there = ", ".join(outer.cells) or "none"
            work.add("/", "undeclared-variable", f"the task declares no variable {name!r} (there are: {there})")
    root = work.part(task.name, "/", task.root, outer)
    ends = Edges.of_children({"/": check_root(task, root.meaning, work.problems)})
    if work.problems:
        raise InvalidTaskError(work.problems, task.name)
    return Resolved(task, root, work.scopes, ends)


class _Resolver:
    def __init__(self, catalog: Catalog):
        self.catalog = catalog
        self.scopes = Scopes()
        self.problems: list[Issue] = []
        self.chain: list[str] = []

    def add(self, path: str, code: str, message: str) -> None:
        self.problems.append(problem(path, code, message))

    def declare(self, path: str, declared: Mapping[str, Variable | str], outer: Scope | None) -> Scope:
        known: dict[str, Variable | str] = {}
        for name, variable in declared.items():
            try:
                parse_type(variable if isinstance(variable, str) else variable.type)
                known[name] = variable
            except ValueError as error:
                self.add(path, "unknown-type", f"variable {name!r}: {error}")
                known[name] = "Any"
        return self.scopes.declare(path, known, outer)

    def preset(self, cell: Cell, value: Any) -> None:
        wrong = check_value(cell.parsed, value)
        if wrong is not None:
            self.add("", "wrong-initial-value", f"variable {cell.name!r} is {cell.type}: {wrong}")
        else:
            cell.preset(value)

    def part(self, name: str, path: str, node: AnyNode, outer: Scope) -> Part:
        if isinstance(node, Leaf):
            return self.leaf(name, path, node, outer)
        if isinstance(node, Subtask):
            return self.subtask(name, path, node, outer)
        scope = self.declare(path, self.variables(path, node, outer), outer)
        outcomes = outcomes_of(node)
        check_expressions(path, node, outer, scope, self.problems)
        self.refusal(path, node, outcomes)
        above, below = join(path, ""), children_of(node)
        children = tuple([self.part(child, above + child, inner, scope) for child, inner in below.items()])
        if isinstance(node, Switch):
            self.cases(path, node)
        if isinstance(node, Foreign) and not self.catalog.code.allows(node.behaviour):
            trouble = not_listed(node.behaviour, self.catalog.code.listed)
            self.problems.append(Issue(path, trouble.code, "error", trouble.message, trouble.fix))
        ends = {child.name: child.meaning for child in children}
        exits = edges = _NO_EDGES
        if isinstance(node, Parallel):
            check_rules(path, node, ends, self.problems)
        if isinstance(node, StateMachine):
            edges = Edges.of_children({child: inner.on for child, inner in below.items()})
            check_edges(path, edges, ends, set(outcomes), node.initial, self.problems)
        else:
            if node.exits:
                exits = Edges.of_exits(node.exits)
                check_edges(path, exits, ends, set(outcomes), None, self.problems)
            for child, inner in below.items():
                if inner.on:
                    self.misplaced(above + child)
        return Part(name, path, node, outcomes, scope, scope is not outer, children, exits, edges)

    def misplaced(self, path: str) -> None:
        self.add(path, "misplaced-on", "`on:` is only for children of a state_machine; use `exits:` of the container")

    def variables(self, path: str, node: Container, outer: Scope) -> Mapping[str, Variable | str]:
        """Return what a container declares, with what it takes out of lists."""
        declared: dict[str, Variable | str] = dict(node.data)
        for key, items, item in node.taken():
            cell = outer.find(items)
            if items in declared:
                held = type_of(declared[items])
            elif cell is not None:
                held = cell.type
            else:
                held = "Any"
                self.add(path, "undeclared-variable", f"`{key}` names {items!r}, which isn't declared here or above")
            try:
                of_list = parse_type(held).item
            except ValueError:
                of_list = None
            declared[item] = str(of_list or "Any")
        return declared

    def cases(self, path: str, node: Switch) -> None:
        for name in (*node.cases, *([node.default] if node.default else [])):
            if name not in node.children:
                self.add(path, "unknown-child", f"a case names {name!r}, which isn't a child")

    def leaf(self, name: str, path: str, node: Leaf, scope: Scope) -> Part:
        try:
            manifest = self.catalog.get(node.node)
        except GripError as error:
            self.add(path, "unknown-node", str(error))
            return Part(name, path, node, {}, scope, False)
        check_leaf(path, node, manifest, scope, self.problems)
        if not (node.precondition or node.meaning):
            return Part(name, path, node, manifest.outcomes, scope, False, manifest=manifest)
        check_expressions(path, node, scope, scope, self.problems)
        meaning = with_refusal(node, manifest.outcomes_for(dict(node.meaning)))
        self.refusal(path, node, meaning)
        return Part(name, path, node, meaning, scope, False, manifest=manifest)

    def subtask(self, name: str, path: str, node: Subtask, outside: Scope) -> Part:
        """Return a subtask with the root of its file as its child, each end of which is an exit."""
        try:
            if node.task in self.chain:
                chain = " -> ".join((*self.chain[self.chain.index(node.task) :], node.task))
                raise SubtaskError(node.task, f"a task can't run itself: {chain}")
            task = self.catalog.tasks.read(node.task)
        except SubtaskError as error:
            code = "recursive-subtask" if node.task in self.chain else "unknown-subtask"
            self.add(path, code, str(error))
            return Part(name, path, node, {}, outside, False)
        face = manifest_of_task(node.task, task)
        check_ports(path, node, face, outside, self.problems)
        check_expressions(path, node, outside, outside, self.problems)
        meaning = with_refusal(node, face.outcomes_for(dict(node.meaning)))
        self.refusal(path, node, meaning)
        scope = self.declare(path, task.variables, None)
        self.chain.append(node.task)
        root = self.part(task.name, f"{path}/", task.root, scope)
        self.chain.pop()
        ends = check_root(task, root.meaning, self.problems, root.path)
        exits = Edges.of_children({root.name: ends})
        return Part(name, path, node, meaning, scope, True, (root,), exits, manifest=face, outside=outside)

    def refusal(self, path: str, node: AnyNode, meaning: Mapping[str, str]) -> None:
        if node.precondition and meaning["failure"] == "success":
            self.add(
                path, "contradictory-outcome", "a precondition needs the outcome `failure`, which means success here"
            )
