"""The containers of a compiled machine: smach's, with a path, a reason carried up, an observer, and variables."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, cast

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure
from grip_bt.compilers.behaviour_state import Halted, MachineRun, Refined, TaskState, label, labels
from grip_bt.compilers.resolve import Part
from grip_bt.nodes.answers import Answers
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.node import LABEL, SILENT, Condition, Node, Observer
from grip_bt.nodes.smach_activation import AmongStates
from grip_bt.nodes.smach_asking import MARK, Enclosing
from grip_bt.smach_compat import Concurrence, State, StateMachine
from grip_bt.task.kinds.base import CHILD, End, Ended, Kind, Next, Reason, Run, Step


class TaskContainer(TaskState):
    """Mixed in before a container of smach.

    Attributes:
        refined: (outcome, code) pairs with labels of their own.
        enter: resets the container's variables, if it declares some.
        condition: the precondition, looked at before anything else.
        hand_out: of a subtask: called when it ends, before anybody learns of it.
    """

    observer: Observer = SILENT
    run: MachineRun
    meaning: Mapping[str, str]
    refined: Refined
    condition: Condition | None = None
    hand_out: Callable[[], None] | None = None

    def take(self, path: str, meaning: Mapping[str, str], refined: Refined, enter: Callable[[], None] | None) -> None:
        self.path, self.meaning, self.refined = path, dict(meaning), frozenset(refined)
        self._entries = [] if enter is None else [enter]

    def on_enter(self, reset: Callable[[], None]) -> None:
        self._entries.append(reset)

    def execute(self, parent_ud: Any = None) -> Any:
        self.outcome = self.failure = None
        self.observer.entered(self.path)
        try:
            if not self._admits():
                return label(self.outcome or "", self.failure, self.refined)
            for reset in self._entries:
                reset()
            reached = super().execute(parent_ud)
            if reached is None:
                raise Halted  # smach's shutdown was asked for
            self.outcome = reached.split(".", 1)[0]
            self.failure = self.reason() if self.meaning[self.outcome] == "failure" else None
            if self.hand_out is not None:
                self.hand_out()
        except BaseException as error:
            self.run.fail(error)
            self.observer.interrupted(self.path)
            raise
        self.observer.ended(self.path, self.outcome, self.failure)
        return reached

    def _admits(self) -> bool:
        try:
            if self.condition is None or self.condition.holds():
                return True
        except Exception as error:
            raise NodeError(self.path, error) from error
        self.outcome, self.failure = "failure", self.condition.refusal("precondition")
        self.observer.ended(self.path, self.outcome, self.failure)
        self.run.turn()  # a loop over nodes that never begin can be stopped too
        return False

    def reason(self) -> Failure | None:
        raise NotImplementedError


class Decide(TaskState):
    """The state that asks a container's kind what follows the last end.

    Its outcomes are `do CHILD`, and the container's.

    Attributes:
        children: label of a child's state -> its position, its state, and the meaning of its outcomes.
        first: the state of the kind, where a child begins without asking.
    """

    def __init__(
        self,
        kind: Kind,
        answers: Answers,
        meaning: Mapping[str, str],
        run: MachineRun,
        refined: Refined,
        keys: Sequence[str] = (),
    ):
        ends = [*(f"do {name}" for name in answers.names), *labels(meaning, refined)]
        State.__init__(self, ends, list(keys), list(keys))
        self.path, self.kind, self.answers, self.run = answers.path, kind, answers, run
        self.meaning, self.refined = meaning, frozenset(refined)
        self.children: dict[str, tuple[int, TaskState, Mapping[str, str]]] = {}
        self.first: Any = None
        self.state: Any = None
        self._at = self._before = ""

    def begin(self, *_: object) -> None:
        self.state, self._at, self._before = self.first, "", ""

    def moved(self, userdata: object, active: list[str], *_: object) -> None:
        self._before, self._at = self._at, active[0]

    def execute(self, userdata: Any) -> str:
        """Ask; a stop is seen here too, since a loop may find nothing to tick."""
        try:
            self.run.turn()
            last = self.children.get(self._before)
            step = self.kind.begin(self.state, self.answers) if last is None else self._after(*last)
            while type(step) is Next:
                step = self.kind.begin(step.state, self.answers)
        except NodeError as error:
            self.run.fail(error)
            raise
        if type(step) is Run:
            self.state = step.state
            return f"do {self.answers.names[step.children[0]]}"
        assert type(step) is End, "a kind whose children run one after the other goes on or ends"
        self.outcome, why = step.outcome, step.reason
        self.failure = why if why is None or isinstance(why, Failure) else None
        if why is CHILD and last is not None:
            self.failure = last[1].failure
        elif isinstance(why, Reason):
            self.failure = Failure(why.code, why.text)
        return label(step.outcome, self.failure, self.refined)

    def _after(self, child: int, state: TaskState, meaning: Mapping[str, str]) -> Step:
        outcome, failure = state.outcome or "", state.failure
        code = failure.code if failure is not None else None
        end = Ended(self.answers.names[child], outcome, meaning[outcome], code, failure)
        return self.kind.ended(self.state, child, end, self.answers)


class TaskMachine(TaskContainer, StateMachine):
    """A container whose children run one after the other."""

    def __init__(
        self, path: str, meaning: Mapping[str, str], refined: Refined = (), enter: Callable[[], None] | None = None
    ):
        StateMachine.__init__(self, labels(meaning, refined))
        self.take(path, meaning, refined, enter)
        self.decide: Decide | None = None
        self._last: TaskState | None = None
        self.register_termination_cb(self._remember)

    def _remember(self, userdata: object, terminal_states: list[str], outcome: str) -> None:
        self._last = self[terminal_states[0]]  # type: ignore[assignment]

    def ask(self, decide: Decide) -> None:
        self.decide = decide
        self.register_start_cb(decide.moved)
        self.register_transition_cb(decide.moved)

    def execute(self, parent_ud: Any = None) -> Any:
        if self.decide is None:
            return super().execute(parent_ud)
        self.decide.begin()
        try:
            return super().execute(parent_ud)
        finally:
            self.decide.kind.over(self.decide.state, self.decide.answers)

    def reason(self) -> Failure | None:
        return self._last.failure if self._last is not None else None


class Joining(Concurrence):
    """A Concurrence that leaves a preempt request to its children, and ends by its `outcome_cb` all the same."""

    def execute(self, parent_ud: Any = None) -> Any:
        if self.preempt_requested():
            self._ask_children()
        return super().execute(parent_ud)

    def request_preempt(self) -> None:
        """Ask every child to stop; the concurrence itself ends when they have ended."""
        State.request_preempt(self)
        self._ask_children()

    def _ask_children(self) -> None:
        for child in self.get_children().values():
            child.request_preempt()


class TaskConcurrence(TaskContainer, Joining):
    """A parallel that joins: each child in its own thread; its kind is asked when all have ended.

    `ends_of` holds, for the label of each child's state, the child's name and the meaning of its outcomes.

    A preempt request travels to all children and is left for them to obey. Upstream would end with the outcome
    `preempted` when no child has seen the request, which a parallel doesn't have.
    """

    def __init__(
        self,
        path: str,
        meaning: Mapping[str, str],
        kind: Kind,
        answers: Answers,
        refined: Refined = (),
        enter: Callable[[], None] | None = None,
    ):
        Concurrence.__init__(self, labels(meaning, refined), default_outcome="failure", outcome_cb=self._choose)
        self.take(path, meaning, refined, enter)
        self.kind, self.answers = kind, answers
        self.ends_of: dict[str, tuple[str, Mapping[str, str]]] = {}

    def decided(self) -> tuple[str, Failure | None]:
        """Return what the children's ends come to, in the document's order, and why."""
        ends = []
        for state_label, (name, meaning) in self.ends_of.items():
            state: Any = self[state_label]
            code = state.failure.code if state.failure is not None else None
            ends.append(Ended(name, state.outcome, meaning[state.outcome], code, state.failure))
        self.answers.ends = ends
        step = self.kind.settle(None, self.answers)
        assert type(step) is End, "all have ended"
        return step.outcome, cast("Failure", step.reason) if self.meaning[step.outcome] == "failure" else None

    def reason(self) -> Failure | None:
        return self.decided()[1]

    def _choose(self, outcomes: Mapping[str, str]) -> str:
        return label(*self.decided(), self.refined)

    def _run_children(self) -> None:
        self._branches: dict[str, AbstractContextManager[object]] = dict(
            zip(self._states, self.run.fork(len(self._states)), strict=True)
        )
        with self.run.joined():
            super()._run_children()

    def _run_child(self, label: str, ready: threading.Event) -> None:
        with self._branches[label]:
            super()._run_child(label, ready)


def enclose(root: Part, nodes: Mapping[str, Node], states: Mapping[str, object]) -> None:
    """Tell every leaf that cares which containers of SMACH are around it, and have these count their entries.

    Args:
        states: what isn't a behaviour but a container of a machine, by path.
    """
    stack: list[tuple[Part, tuple[Enclosing, ...]]] = [(root, ())]
    while stack:
        part, around = stack.pop()
        node = nodes.get(part.path)
        if isinstance(node, AmongStates):
            node.enclosing = around
        kind = part.node.x.get(MARK)
        made = node if isinstance(node, KindNode) else states.get(part.path)
        if isinstance(kind, str) and isinstance(made, KindNode | TaskContainer):
            around = (*around, _enclosing(part.path, kind, made))
        stack.extend((child, around) for child in part.children)


def _enclosing(path: str, kind: str, made: Any) -> Enclosing:
    if isinstance(made, TaskContainer):
        machine: Any = made  # smach's container
        enclosing = Enclosing(path, kind, lambda: made.outcome is None, lambda: len(machine.get_active_states()))
        made.on_enter(enclosing.entered)
        if isinstance(made, TaskConcurrence):  # who waits for the others in it learns that one has ended
            made.register_transition_cb(lambda *_: made.run.wake())
        return enclosing
    enclosing = Enclosing(
        path, kind, lambda: made.active, lambda: sum(child.status not in LABEL for child in made.children)
    )
    first = made.enter

    def enter() -> None:
        if first is not None:
            first()
        enclosing.entered()

    made.enter = enter
    return enclosing
