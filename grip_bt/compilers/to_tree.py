"""Graph -> py_trees behaviour tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

from py_trees.behaviour import Behaviour

from grip_bt.compilers.behaviour_state import Pacer, TaskEnd, drive
from grip_bt.compilers.binding import bind_answers, bind_condition
from grip_bt.compilers.leaves import BehaviourFactory, adopter, hand_in, hand_out
from grip_bt.nodes import control
from grip_bt.nodes.container import KindNode, RunAnswers, container
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node, Observer
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from .enclosing import enclose
from .leaves import LeafFactory, implementation_of, make_leaf, prepare, release
from .resolve import Part, Resolved, resolve
from .scopes import Scopes

_BY_KIND = (model.Switch, model.Loop, model.ForEach, model.Cooldown)


class TreeBuilder:
    """Makes the behaviours of a resolved task, or of a part of it.

    Attributes:
        by_path: every behaviour made so far.
        leaves: those of them that are leaves.
    """

    def __init__(self, scopes: Scopes, factory: LeafFactory, adopt: BehaviourFactory):
        self.scopes, self.factory, self.adopt = scopes, factory, adopt
        self.by_path: dict[str, Node] = {}
        self.leaves: dict[str, Leaf] = {}

    def build(self, part: Part) -> Node:
        """Return the behaviour of `part`, with everything below it."""
        if isinstance(part.node, model.Leaf):
            node: Node = make_leaf(part, self.factory, self.scopes)
            self.leaves[part.path] = cast(Leaf, node)
        else:
            children = [self.build(child) for child in part.children]
            node = self._container(part, manifest_of_task(part), children)
        if part.node.precondition:
            condition = bind_condition(part.path, "precondition", part.node.precondition, part.around, self.scopes)
            control.conditional(node, condition, part.meaning)
        node.document = part.node
        self.by_path[part.path] = node
        return node

    def _container(self, part: Part, face: control.Face, children: list[Behaviour]) -> Node:
        if isinstance(part.node, _BY_KIND):
            return self._by_kind(part, part.node, children)
        if isinstance(part.node, model.Foreign):
            return control.Foreign(face, self.adopt(part.path, part.name, part.node))
        if isinstance(part.node, model.Subtask):
            face = replace(face, enter=hand_in(part, self.scopes))
            return control.Subtask(face, children[0], hand_out(part, self.scopes))
        if isinstance(part.node, model.Guard):
            holds = bind_condition(part.path, "if", part.node.if_, part.scope, self.scopes)
            return control.Guard(face, children[0], holds)
        return _container(part, face, children)

    def _by_kind(self, part: Part, kind: model.Kind, children: list[Behaviour]) -> KindNode:
        answers = RunAnswers(part.path, [child.name for child in part.children], part.exits, part.edges)
        bind_answers(answers, part, kind, self.scopes)
        node = container(part.name, part.meaning, kind, answers, children)
        node.enter = part.scope.reset if part.declares else None
        return node


def ruling_of(part: Part) -> control.Ruling:
    """Return how a parallel is decided."""
    node = part.node
    assert isinstance(node, model.Parallel), "only these have rules"
    rules = [
        control.Match(
            rule.then,
            {child: [said] if isinstance(said, str) else said for child, said in rule.when.items()},
            rule.at_least,
            rule.ends,
        )
        for rule in node.rules
    ]
    return control.Ruling(node.policy, part.exits, rules, node.wait_for)


def manifest_of_task(part: Part) -> control.Face:
    """Return what the container of `part` is made with."""
    enter = part.scope.reset if part.declares else None
    return control.Face(part.name, part.path, part.meaning, part.exits, enter)


def _container(part: Part, face: control.Face, children: list[Behaviour]) -> Node:
    match part.node:
        case model.Sequence(memory=memory):
            return control.Sequence(face, children, memory)
        case model.Fallback(memory=memory):
            return control.Fallback(face, children, memory)
        case model.Parallel(cancel=cancel, retick=retick, prompt=prompt):
            made = control.PromptParallel if prompt else control.Parallel
            node = made(face, children, ruling_of(part), cancel, retick)
            if cancel == "ask":
                for below in node.iterate():
                    if isinstance(below, Leaf):
                        below.askers.append(node)
            return node
        case model.StateMachine(initial=initial):
            return control.Dispatch(face, children, initial, part.edges)
        case model.Retry(times=attempts):
            return control.Retry(face, children[0], attempts)
        case model.Repeat(times=times):
            return control.Repeat(face, children[0], times)
        case model.Timeout(seconds=seconds, child_first=child_first):
            return control.Timeout(face, children[0], seconds, child_first)
        case model.Invert():
            return control.Invert(face, children[0])
        case model.Force(as_=outcome):
            return control.Force(face, children[0], outcome)
    raise TypeError(f"{part.path}: no behaviour for {type(part.node).__name__}")


class CompiledTree:
    """A task as a py_trees tree.

    Attributes:
        task: the document.
        root: the tree; any tool of py_trees works on it.
        data: the run's variables.
        by_path: the behaviours, by path.
        leaves: the leaves, by path, in document order.
    """

    target = "bt"

    def __init__(self, resolved: Resolved, builder: TreeBuilder):
        self._resolved = resolved
        self.task, self.data, self.root = resolved.task, resolved.scopes, builder.build(resolved.root)
        self.by_path, self.leaves = builder.by_path, builder.leaves
        enclose(resolved.root, self.by_path, {})

    def observe(self, observer: Observer) -> None:
        """Have every activation and every write reported to `observer`."""
        self.data.on_write = observer.wrote
        for node in self.by_path.values():
            node.observer = observer

    def prepare(self, context: Any) -> None:
        """Give the run's context to every node and prepare every leaf, once, before the first tick.

        Raises:
            NodeError: a leaf can't be prepared.
        """
        prepare(self.root.iterate(), context)

    def release(self) -> None:
        """Undo `prepare`; nothing runs any more."""
        release(self.root.iterate())

    def execute(self, pacer: Pacer, tick: Callable[[], None] | None = None) -> TaskEnd:
        """Tick until the task ends.

        Args:
            pacer: says when.
            tick: does what `root.tick_once` does, which is the default.

        Raises:
            Halted: the run was stopped; everything was interrupted.
            NodeError: a leaf raised; everything was interrupted.
        """
        self.data[Scopes.TASK].reset()
        drive(self.root, pacer, tick)
        return self.end()

    def end(self) -> TaskEnd:
        """Return how the task has ended; the root has ended."""
        assert self.root.outcome is not None, "the root has ended"
        outcome, meaning = self._resolved.end(self.root.outcome, self.root.code)
        return TaskEnd(outcome, meaning, self.root.failure if meaning == "failure" else None)


def to_tree(
    task: model.Task,
    catalog: Catalog,
    *,
    leaf_factory: LeafFactory | None = None,
    behaviour_factory: BehaviourFactory | None = None,
    data: Mapping[str, Any] | None = None,
) -> CompiledTree:
    """Compile a task to a py_trees behaviour tree; always exact.

    Args:
        task: the document.
        catalog: where manifests and implementations are.
        leaf_factory: makes the leaves instead of the catalogue's implementations.
        behaviour_factory: makes what is in foreign nodes; without it, what the project lists is imported and made.
        data: initial values for the task's own variables, in place of those in the document.

    Raises:
        InvalidTaskError: the task is wrong; it holds everything that was found.
    """
    resolved = resolve(task, catalog, data)
    adopt = behaviour_factory or adopter(catalog.code)
    return CompiledTree(resolved, TreeBuilder(resolved.scopes, leaf_factory or implementation_of, adopt))
