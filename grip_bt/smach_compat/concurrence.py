"""`Concurrence`: all children at once, each in its own thread; it ends when they all have ended."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterable
from typing import Any

from ._settings import hooks, settings
from .container import Container
from .exceptions import InvalidStateError, InvalidTransitionError, InvalidUserCodeError
from .state import State
from .user_data import NOTHING, Remapper, Remapping, UserData

_POLL = 0.1  # [s] how often a shutdown is looked for while children are being joined


class Concurrence(Container):
    """A container that runs its children at the same time on one userdata.

    The entry of the map with most constraints that all hold wins; a callback that returns nothing leaves it at that.
    """

    def __init__(
        self,
        outcomes: Iterable[str],
        default_outcome: str,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
        outcome_map: dict[str, dict[str, str]] | None = None,
        outcome_cb: Callable[[dict[str, str]], str | None] | None = None,
        child_termination_cb: Callable[[dict[str, str | None]], object] | None = None,
    ):
        Container.__init__(self, outcomes, input_keys, output_keys)
        self._states: dict[str, State] = {}
        self._remappings: dict[str, Remapping] = {}
        self._threads: dict[str, threading.Thread] = {}
        self._child_outcomes: dict[str, str | None] = {}
        self._default_outcome = default_outcome
        self._outcome_map = {} if outcome_map is None else outcome_map
        self._outcome_cb = outcome_cb
        self._child_termination_cb = child_termination_cb
        self._check_policy()

        # Callbacks come one at a time. Not under `_done_cond`, so that one may request a preempt of a container
        # further out while another thread does the same.
        self._callback_lock = threading.RLock()
        self._done_cond = threading.Condition()
        # Of one execution, guarded by `_done_cond`:
        self._woken = False
        self._unfinished = 0
        self._error: BaseException | None = None

    def _check_policy(self) -> None:
        outcomes = self.get_registered_outcomes()
        if not isinstance(self._default_outcome, str) or self._default_outcome not in outcomes:
            raise InvalidStateError(
                f"The default outcome {self._default_outcome!r} isn't an outcome of the concurrence: {list(outcomes)}"
            )
        unknown = [outcome for outcome in self._outcome_map if outcome not in outcomes]
        if unknown:
            raise InvalidStateError(
                f"The outcome map names {unknown}, but the outcomes of the concurrence are {list(outcomes)}"
            )
        for name in ("outcome_cb", "child_termination_cb"):
            callback = getattr(self, f"_{name}")
            if callback is not None and not callable(callback):
                raise InvalidStateError(f"{name} is {callback!r}, which can't be called")

    @staticmethod
    def add(label: str, state: State, remapping: Remapping | None = None) -> State:
        """Add a child to the open concurrence; one with the same label is replaced."""
        self = Concurrence._currently_opened_container()
        self._states[label] = state
        self._remappings[label] = {} if remapping is None else remapping
        return state

    def check_consistency(self) -> None:
        """Check the outcome map: KeyError where it names a child that isn't there."""
        for outcome, constraints in self._outcome_map.items():
            for label, child_outcome in constraints.items():
                registered = self._states[label].get_registered_outcomes()
                if child_outcome not in registered:
                    raise InvalidTransitionError(
                        f"The outcome map of {outcome!r} names outcome {child_outcome!r} of state {label!r}, "
                        f"but its outcomes are {list(registered)}"
                    )

    def get_children(self) -> dict[str, State]:
        return self._states

    def set_initial_state(self, initial_states: list[str], userdata: UserData | None = None) -> None:
        """Take over `userdata`; all children always begin, whatever `initial_states` says."""
        if initial_states and set(initial_states) != set(self._states):
            hooks.logwarn("All children of a concurrence begin; the choice of initial states is ignored.")
        if userdata is not None:
            self.userdata.update(userdata)

    def get_initial_states(self) -> list[str]:
        return list(self._states)

    def get_active_states(self) -> list[str]:
        """Return the labels of the children that haven't ended."""
        return [label for label, outcome in self._child_outcomes.items() if outcome is None]

    def get_internal_edges(self) -> list[tuple[str, str, str | None]]:
        """Return (child's outcome, label, outcome of the container) for each constraint of the outcome map."""
        return [
            (child_outcome, label, outcome)
            for outcome, constraints in self._outcome_map.items()
            for label, child_outcome in constraints.items()
        ]

    def execute(self, parent_ud: UserData | Remapper | None = None) -> str:
        """Run all children, wait; `preempted` when a request was obeyed, even where that isn't registered."""
        if not self._states:
            raise InvalidStateError("A concurrence without children can't be executed")
        self._child_outcomes = dict.fromkeys(self._states)
        self._copy_input_keys(parent_ud, self.userdata)
        hooks.loginfo(f"Concurrence starting with userdata: {self.userdata.keys()}")
        self.call_start_cbs()
        self._run_children()
        if self._error is not None:
            error, self._error = self._error, None
            raise error
        outcome = self._decide()
        hooks.loginfo(f"Concurrent outcomes: {self._child_outcomes}; terminating with {outcome!r}")
        self.call_termination_cbs(list(self._states), outcome)
        self._copy_output_keys(self.userdata, parent_ud)
        return outcome

    def request_preempt(self) -> None:
        """Ask the children to stop. Before an execution it only sets the flag, which is seen at the end."""
        self._preempt_requested = True
        self._wake()

    def _wake(self) -> None:
        with self._done_cond:
            self._woken = True
            self._done_cond.notify_all()

    def _run_children(self) -> None:
        """Start all children together; once woken, ask those that run to stop, and wait for them."""
        ready = threading.Event()
        self._error, self._unfinished = None, len(self._states)
        self._threads = {
            label: threading.Thread(name=f"concurrent_split:{label}", target=self._run_child, args=(label, ready))
            for label in self._states
        }
        for thread in self._threads.values():
            thread.start()
        with self._done_cond:
            self._woken = False
            ready.set()
            while not self._woken:
                self._done_cond.wait()
        for label, state in self._states.items():
            if self._child_outcomes[label] is None:
                state.request_preempt()
        with self._done_cond:
            while self._unfinished and not hooks.is_shutdown():
                self._done_cond.wait(_POLL)
            if self._unfinished:
                return
        for thread in self._threads.values():
            thread.join()

    def _run_child(self, label: str, ready: threading.Event) -> None:
        """Run in the child's thread. Whatever happens, the container is told."""
        try:
            ready.wait()
            self.call_transition_cbs()
            self._child_outcomes[label] = self._execute_child(label)
            with self._callback_lock:
                self._child_ended()
        except BaseException as error:  # noqa: BLE001 - `execute` raises it in its caller's thread
            with self._done_cond:
                if self._error is None:
                    self._error = error
        finally:
            with self._done_cond:
                self._unfinished -= 1
                if self._error is not None or self._unfinished == 0:
                    self._woken = True
                self._done_cond.notify_all()

    def _execute_child(self, label: str) -> Any:
        try:
            state = self._states[label]
            outcome = state.execute(self._view(state, self._remappings[label]))
        except Exception as error:
            raise InvalidStateError(
                f"Concurrent state {label!r} raised an exception: {traceback.format_exc()}"
            ) from error
        if outcome is None:
            raise InvalidStateError(f"Concurrent state {label!r} returned no outcome")
        return outcome

    def _child_ended(self) -> None:
        """Tell the observers, and wake the container if the others are to stop; with `_callback_lock` held."""
        self.call_transition_cbs()
        if self._child_termination_cb is None:
            return
        try:
            stop_others = self._child_termination_cb(self._child_outcomes)
        except Exception as error:
            raise InvalidUserCodeError(
                f"Could not call the child termination callback: {traceback.format_exc()}"
            ) from error
        if stop_others:
            self._wake()

    def _decide(self) -> str:
        if self._preempt_requested:
            unserviced = [state for state in self._states.values() if state.preempt_requested()]
            for state in unserviced:
                state.recall_preempt()
            if not unserviced:
                self.service_preempt()
                if not settings.ros2:
                    return "preempted"
        outcome = self._mapped_outcome()
        if self._outcome_cb is None:
            return outcome
        try:
            chosen = self._outcome_cb(self._child_outcomes.copy())  # type: ignore[arg-type]
        except Exception as error:
            raise InvalidUserCodeError(f"Could not call the outcome callback: {traceback.format_exc()}") from error
        return chosen if chosen and isinstance(chosen, str) else outcome

    def _mapped_outcome(self) -> str:
        result, best = self._default_outcome, 0
        for outcome, constraints in self._outcome_map.items():
            if all(self._child_outcomes[label] == wanted for label, wanted in constraints.items()):
                # The ROS 2 branch takes the last entry that holds, an empty one too.
                if settings.ros2 or len(constraints) > best:
                    result, best = outcome, len(constraints)
        return result
