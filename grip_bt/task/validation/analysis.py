"""A task with every name looked up once: what all rules read."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import or_
from typing import Never

from grip_bt.base.errors import ExpressionError, listing, nearest
from grip_bt.base.expression import parse_expression
from grip_bt.base.issue import Issue
from grip_bt.task import (
    AnyNode,
    Foreign,
    Leaf,
    StateMachine,
    Subtask,
    Task,
    Variable,
    children_of,
    expressions_of,
    join,
    outcomes_of,
    with_refusal,
)
from grip_bt.task.catalog import Catalog, Manifest, Type, parse_type
from grip_bt.task.document import Document
from grip_bt.task.parts import type_of

from .codes import SEVERITY, suggestion
from .subtasks import Subtasks

Key = str | tuple[str | int, ...] | None


@dataclass(frozen=True, slots=True)
class VariableDeclaration:
    """A declared variable; `bit` is its place in sets of variables, which are integers.

    `type` is None when it isn't a type, which is an issue of its own.
    """

    name: str
    owner: str
    variable: Variable | str
    bit: int
    type: Type | None
    key: str = "data"
    """Where it is declared: `data`, or `inputs` or `outputs` of a task."""


Scope = Mapping[str, VariableDeclaration]


_NOTHING: Mapping[str, Never] = {}


class PlacedNode:
    """One node in its surroundings.

    Attributes:
        around: the variables that it sees without its own.
        manifest: of a leaf whose type is known, and of a subtask whose file is.
        outcomes: its outcomes and their meanings; of a leaf of unknown type, whatever the task expects of it.
        reads: variables that it or anything below it reads.
    """

    def __init__(self, path: str, name: str, node: AnyNode, parent: PlacedNode | None, scope: Scope):
        self.path, self.name, self.node, self.parent, self.scope = path, name, node, parent, scope
        self.around = scope
        self.manifest: Manifest | None = None
        self.outcomes: Mapping[str, str] = _NOTHING
        self.children: Mapping[str, PlacedNode] = _NOTHING
        self.reads = self.writes = 0

    @cached_property
    def codes(self) -> frozenset[str] | None:
        """Failure codes that it may end with, those of everything below it among them; None when they aren't known."""
        own = _codes_of(self)
        return own if own is None or not self.node.precondition else own | {"precondition"}

    def scope_of(self, key: str) -> Scope:
        """Return the variables that its expression at `key` sees: of a precondition, those around the node."""
        return self.around if key == "precondition" else self.scope

    def expressions(self) -> Iterator[tuple[str, list[VariableDeclaration]]]:
        """Yield the key of each readable expression, and the declared variables that it reads."""
        for key, text in expressions_of(self.node):
            try:
                names = parse_expression(text).names
            except ExpressionError:
                continue  # another rule says so
            scope = self.scope_of(key)
            yield key, [scope[name] for name in names if name in scope]

    @property
    def in_machine(self) -> bool:
        """Whether it is a child of a state machine."""
        return self.parent is not None and isinstance(self.parent.node, StateMachine)


class TaskAnalysis:
    """All nodes and variables of a task.

    Attributes:
        nodes: every node, parents first, in document order.
        containers: those of them that are neither leaves nor subtasks.
        declared: every variable, in document order.
        written: output of the task -> its outcomes with which it has surely been written; the data flow says so.
    """

    def __init__(
        self, task: Task, catalog: Catalog, document: Document | None = None, subtasks: Subtasks | None = None
    ):
        self.task, self.catalog = task, catalog
        self.subtasks = subtasks or Subtasks(catalog, lambda inside: ([], {}))
        self.written: dict[str, tuple[str, ...]] = {}
        self._document = document
        self.declared: list[VariableDeclaration] = []
        self.issues: list[Issue] = []
        self.task_scope = self._scope({}, "", task.variables)
        self.leaves: list[PlacedNode] = []
        self.containers: list[PlacedNode] = []
        self.nodes = self._nodes()
        for placed in reversed(self.nodes):
            self._sum_up(placed)

    @property
    def root(self) -> PlacedNode:
        """The root's placed."""
        return self.nodes[0]

    def add(self, path: str, key: Key, code: str, message: str, fix: str = "") -> None:
        """Note an issue, of a code of `SEVERITY`, at a key of the node at `path`."""
        place = self._document.position(path, key) if self._document else None
        line, column = place or (None, None)
        source = self._document.source if self._document else ""
        keys = (key,) if isinstance(key, str) else key or ()
        self.issues.append(Issue(path, code, SEVERITY[code], message, fix, line, column, source, keys))

    def unknown(
        self,
        path: str,
        key: Key,
        code: str,
        message: str,
        name: str,
        allowed: Collection[str],
        otherwise: str = "",
        fix: str = "",
    ) -> None:
        """Note a name that isn't among the allowed ones.

        What to do is `fix`, or else to write the nearest of them, or `otherwise` where none is near.
        """
        hint = nearest(name, allowed)
        message = f"{message}{hint} (available: {listing(allowed)})"
        self.add(path, key, code, message, fix or suggestion(hint, otherwise))

    def _scope(self, outer: Scope, owner: str, data: Mapping[str, Variable | str]) -> Scope:
        if not data:
            return outer
        scope = dict(outer)
        for name, variable in data.items():
            bit = 1 << len(self.declared)
            key = "data" if owner or name in self.task.data else "inputs" if name in self.task.inputs else "outputs"
            scope[name] = VariableDeclaration(name, owner, variable, bit, type_or_none(type_of(variable)), key)
            self.declared.append(scope[name])
        return scope

    def _nodes(self) -> list[PlacedNode]:
        nodes: list[PlacedNode] = []
        stack = [PlacedNode("/", self.task.name, self.task.root, None, self.task_scope)]
        while stack:
            placed = stack.pop()
            nodes.append(placed)
            node = placed.node
            if isinstance(node, Leaf | Subtask):
                self._look_up(placed, node)
                continue
            self.containers.append(placed)
            placed.outcomes = outcomes_of(node)
            scope = self._scope(placed.scope, placed.path, node.data)
            for _, items, item in node.taken():
                held = scope.get(items)
                of_list = held.type.item if held is not None and held.type is not None else None
                scope = self._scope(scope, placed.path, {item: str(of_list or "Any")})
            above = join(placed.path, "")
            placed.scope = scope
            placed.children = {
                name: PlacedNode(above + name, name, child, placed, scope) for name, child in children_of(node).items()
            }
            stack.extend(reversed(placed.children.values()))
        return nodes

    def _look_up(self, placed: PlacedNode, node: Leaf | Subtask) -> None:
        if isinstance(node, Subtask):
            manifest, _ = self.subtasks.look(node.task)
        else:
            self.leaves.append(placed)
            manifest = self.catalog.get(node.node) if node.node in self.catalog else None
        placed.manifest = manifest
        if manifest is None:
            placed.outcomes = _expected_outcomes(placed, node)
        elif node.meaning or node.precondition:
            placed.outcomes = with_refusal(node, manifest.outcomes_for(dict(node.meaning)))
        else:
            placed.outcomes = manifest.outcomes

    def _sum_up(self, placed: PlacedNode) -> None:
        node, scope = placed.node, placed.scope
        if isinstance(node, Leaf | Subtask | Foreign):
            placed.reads |= _bits(scope, node.in_.values())
            placed.writes |= _bits(scope, node.out.values())
        if not isinstance(node, Leaf):
            placed.reads |= _bits(scope, (items for _, items, _ in node.taken()))
        for _, read in placed.expressions():
            for declared in read:
                placed.reads |= declared.bit
        if placed.parent is not None:
            placed.parent.reads |= placed.reads
            placed.parent.writes |= placed.writes


def _codes_of(placed: PlacedNode) -> frozenset[str] | None:
    """Return the codes that a node may fail with, without its precondition's; None when they aren't known."""
    node = placed.node
    if isinstance(node, Leaf):
        fails = "failure" in placed.outcomes.values()
        known = () if placed.manifest is None or not fails else placed.manifest.codes
        return frozenset(known) if known or (not fails and placed.manifest is not None) else None
    if isinstance(node, Subtask):
        return None  # a manifest has them, and the file's face has none
    found = set(node.codes)
    for child in placed.children.values() if node.keeps_codes else ():
        codes = child.codes
        if codes is None:
            return None
        found |= codes
    return frozenset(found)


def _bits(scope: Scope, names: Iterable[str]) -> int:
    return reduce(or_, (scope[name].bit for name in names if name in scope), 0)


def type_or_none(text: str) -> Type | None:
    """Return the type that a text names; None where it names none."""
    try:
        return parse_type(text)
    except ValueError:
        return None


def _expected_outcomes(placed: PlacedNode, node: Leaf | Subtask) -> dict[str, str]:
    """Return what a task expects of a leaf that isn't known, so that one wrong name isn't reported many times."""
    expected = dict.fromkeys((key.partition(".")[0] for key in node.on), "failure")
    parent = placed.parent.node if placed.parent is not None else None
    if parent is not None and not isinstance(parent, Leaf | Subtask | StateMachine):
        for key in parent.exits:
            child, _, label = key.partition(".")
            if child == placed.name:
                expected[label.partition(".")[0]] = "failure"
    if placed.in_machine:
        expected = expected or {"success": "success"}
    else:
        expected["failure"] = "failure"
    if "success" in expected or not placed.in_machine:
        expected["success"] = "success"
    return {**expected, **node.meaning}
