"""The containers of a compiled machine: smach's, with a path, a reason carried up, an observer, and variables."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure
from grip_bt.nodes.control import Condition, End, Ruling, first_reason
from grip_bt.nodes.observer import SILENT, Observer
from grip_bt.smach_compat import Concurrence, State, StateMachine

from .behaviour_state import MachineRun, Refined, TaskState, label, labels
from .choice import Choice
from .drive import Halted


class TaskContainer(TaskState):
    """Mixed in before a container of smach.

    Attributes:
        run: what the machine's states share; it learns of errors.
        meaning: each outcome -> success or failure.
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
        """Become the container of the node at `path`."""
        self.path, self.meaning, self.refined = path, dict(meaning), frozenset(refined)
        self._entries = [] if enter is None else [enter]

    def on_enter(self, reset: Callable[[], None]) -> None:
        """Have `reset` called each time the container is entered."""
        self._entries.append(reset)

    def execute(self, parent_ud: Any = None) -> Any:
        """Execute as smach does, and report where the activation begins and ends."""
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
        """Look at the precondition; where it is false, the container has ended."""
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
        """Return why the container fails."""
        raise NotImplementedError


class TaskMachine(TaskContainer, StateMachine):
    """A container whose children run one after the other."""

    def __init__(
        self,
        path: str,
        meaning: Mapping[str, str],
        refined: Refined = (),
        enter: Callable[[], None] | None = None,
    ):
        StateMachine.__init__(self, labels(meaning, refined))
        self.take(path, meaning, refined, enter)
        self.choice: Choice | None = None
        self._last: TaskState | None = None
        self.register_termination_cb(self._remember)

    def _remember(self, userdata: Any, terminal_states: list[str], outcome: str) -> None:
        self._last = self[terminal_states[0]]  # type: ignore[assignment]

    def execute(self, parent_ud: Any = None) -> Any:
        """Execute; a rule learns when that begins and ends, whatever ends it."""
        if self.choice is None:
            return super().execute(parent_ud)
        self.choice.rule.begin()
        try:
            return super().execute(parent_ud)
        finally:
            self.choice.rule.over()

    def reason(self) -> Failure | None:
        """Return the reason of the state that ended the machine."""
        return self._last.failure if self._last is not None else None


class TaskConcurrence(TaskContainer, Concurrence):
    """A parallel that joins: each child in its own thread; the rule is read when all have ended.

    `ends_of` holds, for the label of each child's state, the child's name and the meaning of its outcomes.

    A preempt request travels to all children and is left for them to obey. Upstream would end with the outcome
    `preempted` when no child has seen the request, which a parallel doesn't have.
    """

    def __init__(
        self,
        path: str,
        meaning: Mapping[str, str],
        ruling: Ruling,
        refined: Refined = (),
        enter: Callable[[], None] | None = None,
    ):
        Concurrence.__init__(self, labels(meaning, refined), default_outcome="failure", outcome_cb=self._choose)
        self.take(path, meaning, refined, enter)
        self.ruling = ruling
        self.ends_of: dict[str, tuple[str, Mapping[str, str]]] = {}

    def ends(self) -> list[End]:
        """Return how each child has ended, in the document's order."""
        result = []
        for state_label, (name, meaning) in self.ends_of.items():
            state: Any = self[state_label]
            result.append(End(name, state.outcome, meaning[state.outcome], state.failure))
        return result

    def reason(self) -> Failure | None:
        """Return the reason of the first child that accounts for the outcome."""
        return first_reason(self.ends(), self.ruling.exits, self.outcome or "failure")

    def _choose(self, outcomes: Mapping[str, str]) -> str:
        ends = self.ends()
        outcome = self.ruling.outcome(ends) or "failure"
        failure = first_reason(ends, self.ruling.exits, outcome) if self.meaning[outcome] == "failure" else None
        return label(outcome, failure, self.refined)

    def execute(self, parent_ud: Any = None) -> Any:
        """Bring a request that came before to the children, then execute."""
        if State.preempt_requested(self):
            self._ask_children()
        return super().execute(parent_ud)

    def _run_children(self) -> None:
        self._branches: dict[str, AbstractContextManager[object]] = dict(
            zip(self._states, self.run.fork(len(self._states)), strict=True)
        )
        with self.run.joined():
            super()._run_children()

    def _run_child(self, label: str, ready: threading.Event) -> None:
        with self._branches[label]:
            super()._run_child(label, ready)

    def request_preempt(self) -> None:
        """Ask every child to stop; the concurrence itself ends when they have ended."""
        State.request_preempt(self)
        self._ask_children()

    def _ask_children(self) -> None:
        for child in self.get_children().values():
            child.request_preempt()


class Count(TaskState):
    """Counts the attempts of its machine; `again` or, when there were enough, `enough`.

    Args:
        child: whose attempts are counted; its reason becomes that of `enough`.
        times: how many attempts there are in all.
        refined: codes for which `enough` has a label of its own.
    """

    def __init__(self, child: TaskState, times: int, refined: Refined = ()):
        State.__init__(self, labels(("again", "enough"), refined))
        self.child, self.times, self.refined = child, times, frozenset(refined)
        self.path = child.path
        self.attempts = 0

    def reset(self) -> None:
        """Begin to count; called when the machine is entered."""
        self.attempts = 0

    def execute(self, userdata: Any) -> str:
        """Count one attempt."""
        self.attempts += 1
        if self.attempts < self.times:
            self.outcome, self.failure = "again", None
            return "again"
        self.outcome, self.failure = "enough", self.child.failure
        return label("enough", self.failure, self.refined)
