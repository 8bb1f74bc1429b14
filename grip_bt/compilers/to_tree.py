"""Graph -> py_trees behaviour tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import cast

from grip_bt.compilers.behaviour_state import Pacer, TaskEnd, drive
from grip_bt.compilers.binding import (
    BehaviourFactory,
    LeafFactory,
    adopter,
    bind_answers,
    bind_condition,
    implementation_of,
    make_leaf,
    prepare,
    release,
    variables_of,
)
from grip_bt.compilers.task_machine import enclose
from grip_bt.nodes.container import KindNode, RunAnswers, container
from grip_bt.nodes.control import ControlNode
from grip_bt.nodes.foreign import Foreign, Shared
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node, Observer, conditional
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from .resolve import Part, Resolved, resolve
from .scopes import Scopes


class TreeBuilder:
    """Makes the behaviours of a resolved task, or of a part of it."""

    def __init__(self, scopes: Scopes, factory: LeafFactory, adopt: BehaviourFactory):
        self.scopes, self.factory, self.adopt = scopes, factory, adopt
        self.by_path: dict[str, Node] = {}
        self.leaves: dict[str, Leaf] = {}

    def build(self, part: Part) -> Node:
        if isinstance(part.node, model.Leaf):
            node: Node = make_leaf(part, self.factory, self.scopes)
            self.leaves[part.path] = cast(Leaf, node)
        else:
            children = [self.build(child) for child in part.children]
            node = self._container(part, part.node, children)
        if part.node.precondition:
            condition = bind_condition(part.path, "precondition", part.node.precondition, part.around, self.scopes)
            conditional(node, condition, part.meaning)
        node.document = part.node
        self.by_path[part.path] = node
        return node

    def _container(self, part: Part, kind: model.Kind, children: list[Node]) -> Node:
        if isinstance(kind, model.Foreign):
            behaviour = self.adopt(part.path, part.name, kind, children)
            return Foreign(part.name, part.path, part.meaning, behaviour, self._shared(part, kind))
        answers = RunAnswers(part.path, part.exits, part.edges)
        bind_answers(answers, part, kind, self.scopes)
        cls = ControlNode if isinstance(kind, model.Control) else KindNode
        node = container(part.name, part.meaning, kind, answers, children, cls)
        node.enter, node.leave = variables_of(part, self.scopes)
        if kind.may_ask:
            for below in node.iterate():
                if isinstance(below, Leaf):
                    below.askers.append(node)
        return node

    def _shared(self, part: Part, kind: model.Foreign) -> dict[str, Shared]:
        found: dict[str, Shared] = {}
        for key, name in {**kind.in_, **kind.out}.items():
            cell = part.scope.cell(name)
            write = self.scopes.writer(part.path, key, cell) if key in kind.out else None
            found[key] = cell, write
        return found


class CompiledTree:
    """A task as a py_trees tree.

    Attributes:
        root: the tree; any tool of py_trees works on it.
        leaves: the leaves, by path, in document order.
    """

    target = "bt"

    def __init__(self, resolved: Resolved, builder: TreeBuilder):
        self._resolved = resolved
        self.task, self.data, self.root = resolved.task, resolved.scopes, builder.build(resolved.root)
        self.by_path, self.leaves = builder.by_path, builder.leaves
        enclose(resolved.root, self.by_path, {})

    def ticker(self) -> Callable[[], object] | None:
        """Return what ticks it, where the runner's engine isn't to."""
        return None

    def observe(self, observer: Observer) -> None:
        self.data.on_write = observer.wrote
        for node in self.by_path.values():
            node.observer = observer

    def prepare(self, context: object) -> None:
        """Give the run's context to every node and prepare every leaf, once, before the first tick.

        Raises:
            NodeError: a leaf can't be prepared.
        """
        prepare(self.root.iterate(), context)

    def release(self) -> None:
        release(self.root.iterate())

    def execute(self, pacer: Pacer, tick: Callable[[], None] | None = None) -> TaskEnd:
        """Tick until the task ends.

        Args:
            tick: does what `root.tick_once` does, which is the default.

        Raises:
            Halted: the run was stopped; everything was interrupted.
            NodeError: a leaf raised; everything was interrupted.
        """
        self.data[Scopes.TASK].reset()
        drive(self.root, pacer, tick)
        return self.end()

    def end(self) -> TaskEnd:
        assert self.root.outcome is not None, "the root has ended"
        outcome, meaning = self._resolved.end(self.root.outcome, self.root.code)
        return TaskEnd(outcome, meaning, self.root.failure if meaning == "failure" else None)


def to_tree(
    task: model.Task,
    catalog: Catalog,
    *,
    leaf_factory: LeafFactory | None = None,
    behaviour_factory: BehaviourFactory | None = None,
    data: Mapping[str, object] | None = None,
) -> CompiledTree:
    """Compile a task to a py_trees behaviour tree; always exact.

    Args:
        leaf_factory: makes the leaves instead of the catalogue's implementations.
        behaviour_factory: makes what is in foreign nodes; without it, what the project lists is imported and made.
        data: initial values for the task's own variables, in place of those in the document.

    Raises:
        InvalidTaskError: the task is wrong; it holds everything that was found.
    """
    resolved = resolve(task, catalog, data)
    adopt = behaviour_factory or adopter(catalog.code)
    return CompiledTree(resolved, TreeBuilder(resolved.scopes, leaf_factory or implementation_of, adopt))
