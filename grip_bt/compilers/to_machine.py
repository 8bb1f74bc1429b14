"""Graph -> SMACH machine: one container per composite, and what interrupts a running child embedded as one state."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from grip_bt import smach_compat
from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.binding import (
    BehaviourFactory,
    LeafFactory,
    adopter,
    answers_of,
    bind_condition,
    implementation_of,
    release,
    variables_of,
)
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node, Observer
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from .behaviour_state import BehaviourState, Halted, MachineRun, MakeTicker, Pacer, Refined, TaskEnd, TaskState, labels
from .machine_table import AGAIN, asks, first_step, interrupts, kind_of, state_labels, table_of
from .resolve import Part, Resolved, resolve
from .scopes import Scopes
from .task_machine import Decide, TaskConcurrence, TaskContainer, TaskMachine, enclose
from .to_tree import TreeBuilder

_log = logging.getLogger("grip_bt.smach")


class MachineBuilder:
    """Makes the states of a resolved task.

    Attributes:
        by_path: every state and container, and every behaviour inside an embedded sub-tree.
    """

    def __init__(self, tree: TreeBuilder, run: MachineRun, embed: bool = True):
        self.tree, self.run, self.embed = tree, run, embed
        self.states: dict[str, TaskState] = {}

    def build(self, part: Part, needed: Refined) -> TaskState:
        """Return the state of `part`.

        Args:
            needed: (outcome, code) pairs for which the parent has an edge.

        Raises:
            NotExpressibleError: it interrupts a running child, and embedding isn't allowed.
        """
        if isinstance(part.node, model.Leaf | model.Foreign):
            state: TaskState = BehaviourState(self.tree.build(part), self.run, needed)
        elif interrupts(part):
            if not self.embed:
                what = f"a {part.node.kind} that interrupts a running child, or has none,"
                raise NotExpressibleError(part.path, what, "a machine of blocking states")
            state = BehaviourState(self.tree.build(part), self.run, needed)
        elif part.node.joins:
            state = self._concurrence(part, needed)
        else:
            state = self._machine(part, needed)
        if isinstance(state, TaskContainer):
            state.run = self.run
        if part.node.precondition and isinstance(state, TaskContainer):
            text = part.node.precondition
            state.condition = bind_condition(part.path, "precondition", text, part.around, self.tree.scopes)
        self.states[part.path] = state
        return state

    def _machine(self, part: Part, needed: Refined) -> TaskMachine:
        table, names = table_of(part, needed), state_labels(part)
        enter, leave = variables_of(part, self.tree.scopes)
        machine = TaskMachine(part.path, part.meaning, needed, enter)
        machine.hand_out = leave
        with machine:
            for child in part.children:
                state = self.build(child, table.refined[child.name])
                TaskMachine.add(names[child.name], state, table.rows[names[child.name]])
            if asks(part):
                self._decide(part, machine, needed)
            machine.set_initial_state([table.initial])
        return machine

    def _decide(self, part: Part, machine: TaskMachine, needed: Refined) -> None:
        refined = {(outcome, code) for outcome, code in needed if part.meaning.get(outcome) == "failure"}
        answers, names, first = answers_of(part, self.tree.scopes), state_labels(part), first_step(part)
        decide = Decide(kind_of(part), answers, part.meaning, self.run, refined)
        decide.first = first.state if first is not None else None
        for i, child in enumerate(part.children):
            decide.children[names[child.name]] = (i, self.states[child.path], child.meaning)
        ways = {f"do {child.name}": names[child.name] for child in part.children}
        TaskMachine.add(AGAIN, decide, {**ways, **{end: end for end in labels(part.meaning, refined)}})
        machine.ask(decide)

    def _concurrence(self, part: Part, needed: Refined) -> TaskConcurrence:
        enter = part.scope.reset if part.declares else None
        answers = answers_of(part, self.tree.scopes)
        machine = TaskConcurrence(part.path, part.meaning, kind_of(part), answers, needed, enter)
        names = state_labels(part)
        with machine:
            for child in part.children:
                TaskConcurrence.add(names[child.name], self.build(child, ()))
                machine.ends_of[names[child.name]] = (child.name, child.meaning)
        return machine


class CompiledMachine:
    """A task as a machine of smach_compat.

    Attributes:
        machine: the machine; its one state is the root of the task, its outcomes are the task's.
        by_path: states and containers by path; inside an embedded sub-tree, behaviours.
        ends: label of the root's end -> outcome of the task, as the document has it.
    """

    target = "sm"

    def __init__(self, resolved: Resolved, builder: MachineBuilder, machine: smach_compat.StateMachine):
        self._resolved, self._run = resolved, builder.run
        self._root = builder.states["/"]
        self.ends = {
            outcome if code is None else f"{outcome}.{code}": target for (_, outcome, code), target in resolved.ends
        }
        self.task, self.data, self.machine = resolved.task, resolved.scopes, machine
        self._nodes: Mapping[str, Node] = builder.tree.by_path
        self.by_path: dict[str, Any] = {**builder.tree.by_path, **builder.states}
        enclose(resolved.root, self._nodes, builder.states)
        self.leaves = {
            part.path: leaf for part in resolved.root.walk() if isinstance(leaf := self._nodes.get(part.path), Leaf)
        }

    def observe(self, observer: Observer) -> None:
        self.data.on_write = observer.wrote
        for node in self._nodes.values():
            node.observer = observer
        for state in self.by_path.values():
            if isinstance(state, TaskContainer):
                state.observer = observer

    def prepare(self, context: Any) -> None:
        """Give the run's context to every node and prepare every leaf, once, before the machine is executed.

        Raises:
            NodeError: a leaf can't be prepared.
        """
        for state in self.by_path.values():
            if isinstance(state, BehaviourState):
                state.prepare(context)
            elif isinstance(state, TaskMachine) and state.decide is not None:
                state.decide.answers.context = context

    def release(self) -> None:
        nodes = {id(below): below for node in self._nodes.values() for below in node.iterate()}
        release(nodes.values())

    def request_preempt(self) -> None:
        """Ask the task to come to an end on its own terms: smach's flag, which travels to the active state."""
        self.machine.request_preempt()

    def execute(self, pacer: Pacer, make_ticker: MakeTicker | None = None) -> TaskEnd:
        """Execute the machine in this thread; each active state ticks its behaviour as the pacer says.

        Args:
            make_ticker: makes, for the behaviour of a state, what does its `tick_once`, which is the default.

        Raises:
            Halted: the run was stopped; everything was interrupted, and no recovery state ran.
            NodeError: a leaf raised; everything was interrupted.
        """
        self._run.pacer, self._run.make_ticker, self._run.error = pacer, make_ticker, None
        self.data[Scopes.TASK].reset()
        try:
            with _logged():
                outcome = self.machine.execute()
        except BaseException as error:
            self._run.fail(error)  # whatever still runs in other threads ends too
            if self._run.error is not None and self._run.error is not error:
                raise self._run.error from self._run.error.__cause__
            raise
        if outcome is None:
            raise Halted  # smach's shutdown was asked for
        meaning = self.task.outcomes[outcome]
        return TaskEnd(outcome, meaning, self._root.failure if meaning == "failure" else None)


def to_machine(
    task: model.Task,
    catalog: Catalog,
    *,
    leaf_factory: LeafFactory | None = None,
    behaviour_factory: BehaviourFactory | None = None,
    data: Mapping[str, object] | None = None,
    embed: bool = True,
) -> CompiledMachine:
    """Compile a task to a machine of smach_compat; exact, or refused.

    Args:
        leaf_factory: makes the leaves instead of the catalogue's implementations.
        behaviour_factory: makes what is in foreign nodes; without it, what the project lists is imported and made.
        data: initial values for the task's own variables, in place of those in the document.
        embed: allow a sub-tree that interrupts a running child to become one state that ticks it.

    Raises:
        InvalidTaskError: the task is wrong; it holds everything that was found.
        NotExpressibleError: `embed` is off and a part interrupts a running child.
    """
    resolved = resolve(task, catalog, data)
    adopt = behaviour_factory or adopter(catalog.code)
    tree = TreeBuilder(resolved.scopes, leaf_factory or implementation_of, adopt)
    builder = MachineBuilder(tree, MachineRun(), embed)
    needed = {(outcome, code) for (_, outcome, code), _ in resolved.ends if code is not None}
    with _logged():  # smach would print what is refused
        root = builder.build(resolved.root, needed)
    machine = smach_compat.StateMachine(list(task.outcomes))
    compiled = CompiledMachine(resolved, builder, machine)
    name = task.name
    while name in task.outcomes:
        name += "'"
    with machine:
        smach_compat.StateMachine.add(name, root, dict(compiled.ends))
    return compiled


_loggers_lock = threading.Lock()


@contextmanager
def _logged() -> Iterator[None]:
    """Send smach's messages, which go to stdout by default, to Python's logging while a compiled machine runs."""
    names = ("loginfo", "logwarn", "logdebug", "logerr")
    ours = (_log.debug, _log.warning, _log.debug, _log.debug)
    with _loggers_lock:
        before = tuple(getattr(smach_compat, name) for name in names)
        for name, function in zip(names, ours, strict=True):
            setattr(smach_compat, name, function)
    try:
        yield
    finally:
        with _loggers_lock:
            for name, function in zip(names, before, strict=True):
                setattr(smach_compat, name, function)
