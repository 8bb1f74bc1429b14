"""`StateMachine`: one state at a time, each outcome leads to another state or out."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Iterable
from typing import Any

from ._settings import hooks, settings
from .container import Container
from .exceptions import InvalidStateError, InvalidTransitionError, InvalidUserCodeError
from .state import State
from .user_data import NOTHING, Remapper, Remapping, UserData


class StateMachine(Container):
    """A finite state machine; keys are copied in from the parent when an execution begins, and out when it ends."""

    def __init__(
        self,
        outcomes: Iterable[str],
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
    ):
        Container.__init__(self, outcomes, input_keys, output_keys)
        # Legacy code reads and writes these, so they stay plain and are read afresh at each transition.
        self._states: dict[str, State] = {}
        self._transitions: dict[str, dict[str, str | None]] = {}
        self._remappings: dict[str, Remapping] = {}
        self._constants: dict[str, dict[str, Any]] = {}
        self._initial_state_label: str | None = None

        self._current_label: str | None = None
        self._current_state: Any = None
        self._current_transitions: dict[str, Any] | None = None
        self._preempted_label: str | None = None
        self._preempted_state: State | None = None
        self._is_running = False
        # Re-entrant, so that a callback may request a preempt; upstream hangs there.
        self._state_transitioning_lock: Any = threading.RLock()

        self._last_added_label: str | None = None
        self._connector_outcomes: list[str] = []

    @staticmethod
    def add(
        label: str,
        state: State,
        transitions: dict[str, Any] | None = None,
        remapping: Remapping | None = None,
        constants: dict[str, Any] | None = None,
    ) -> State:
        """Add a state to the open machine; the first one is where it begins. Return it.

        Args:
            transitions: outcome -> label of a state or outcome of the machine. Outcomes left out are added to this very
                dict as None: they end the machine with the outcome of the same name.
            remapping: the state's key -> the machine's key.
            constants: the machine's key -> value, written before each execution of this state.
        """
        self = StateMachine._currently_opened_container()
        if constants is not None and settings.ros2:
            raise TypeError("add() got an unexpected keyword argument 'constants' (profile ros2)")
        transitions = {} if transitions is None else transitions
        if self._initial_state_label is None:
            self._initial_state_label = label
        self.check_state_spec(label, state, transitions)
        if label in self._states:
            raise InvalidStateError(f"A state labelled {label!r} is in this machine already")
        for outcome in state.get_registered_outcomes():
            transitions.setdefault(outcome, None)
        self._states[label] = state
        self._transitions[label] = transitions
        self._remappings[label] = {} if remapping is None else remapping
        if constants is not None:
            self._constants[label] = constants
        if self._last_added_label is not None:  # by `add_auto`
            self._transitions[self._last_added_label] |= dict.fromkeys(self._connector_outcomes, label)
        self._last_added_label, self._connector_outcomes = None, []
        return state

    @staticmethod
    def add_auto(
        label: str,
        state: State,
        connector_outcomes: Iterable[str],
        transitions: dict[str, Any] | None = None,
        remapping: Remapping | None = None,
        constants: dict[str, Any] | None = None,
    ) -> State:
        """Add a state whose `connector_outcomes` lead to whatever state is added next, whatever `transitions` says."""
        self = StateMachine._currently_opened_container()
        StateMachine.add(label, state, transitions, remapping, constants)
        outcomes = state.get_registered_outcomes()
        for outcome in connector_outcomes:
            if outcome not in outcomes:
                raise InvalidStateError(
                    f"Connector outcome {outcome!r} isn't an outcome of state {label!r}: {list(outcomes)}"
                )
        self._last_added_label, self._connector_outcomes = label, list(connector_outcomes)
        return state

    def check_consistency(self) -> None:
        """Check that it begins somewhere and every outcome leads somewhere."""
        states, outcomes = self._states, self.get_registered_outcomes()
        if self._initial_state_label is None:
            raise InvalidTransitionError("The machine has no initial state")
        if self._initial_state_label not in states:
            raise InvalidTransitionError(
                f"The initial state {self._initial_state_label!r} isn't in the machine: {list(states)}"
            )
        for label, transitions in self._transitions.items():
            for outcome, target in transitions.items():
                # Without a target an outcome falls through to the machine's outcome of the same name.
                if target not in states and (target or outcome) not in outcomes:
                    raise self._leads_nowhere(label, outcome, target or outcome)

    def _leads_nowhere(self, label: str, outcome: str, target: str | None) -> InvalidTransitionError:
        return InvalidTransitionError(
            f"Outcome {outcome!r} of state {label!r} leads to {target!r}, neither a state {list(self._states)} "
            f"nor an outcome {list(self.get_registered_outcomes())} of the machine"
        )

    def __getitem__(self, key: str) -> State:
        if key not in self._states:
            hooks.logerr(f"There is no state {key!r} in the machine; there are: {list(self._states)}")
        return self._states[key]

    def get_children(self) -> dict[str, State]:
        return self._states

    def set_initial_state(self, initial_states: list[str], userdata: UserData | None = None) -> None:
        """Begin at the first of these labels, which may be added later, and take over `userdata`."""
        if len(initial_states) > 1:
            hooks.logwarn(f"A machine begins in one state; {initial_states[1:]} are ignored.")
        if initial_states:
            self._initial_state_label = initial_states[0]
        if userdata is not None:
            self.userdata.update(userdata)

    def get_initial_states(self) -> list[str]:
        return [str(self._initial_state_label)]

    def get_active_states(self) -> list[str]:
        """Return the label of the current state; ['None'] when idle."""
        return [str(self._current_label)]

    def get_internal_edges(self) -> list[tuple[str, str, str | None]]:
        """Return all (outcome, label, target); the target is None where the outcome falls through."""
        return [
            (outcome, label, target)
            for label, transitions in self._transitions.items()
            for outcome, target in transitions.items()
        ]

    def is_running(self) -> bool:
        return self._is_running

    def execute(self, parent_ud: UserData | Remapper | None = None) -> str | None:
        """Run to an outcome of the machine; None when it is inconsistent, or a shutdown was asked for."""
        with self._state_transitioning_lock:
            try:
                self.check_consistency()
            except (InvalidStateError, InvalidTransitionError):
                hooks.logerr("Container consistency check failed.")
                return None
            self._is_running = True
            try:
                outcome = self._run(parent_ud)
            except BaseException:
                if not settings.ros2:
                    self._is_running = False
                raise
            self._is_running = False
            return outcome

    def _run(self, parent_ud: UserData | Remapper | None) -> str | None:
        # The request itself is kept: one that came before the execution preempts the initial state.
        self._preempted_label = self._preempted_state = None
        self._set_current_state(self._initial_state_label)
        self._copy_input_keys(parent_ud, self.userdata)
        hooks.loginfo(
            f"State machine starting in initial state {self._current_label!r} with userdata: {self.userdata.keys()}"
        )
        self.call_start_cbs()
        outcome = self._loop()
        self._copy_output_keys(self.userdata, parent_ud)
        return outcome

    def _loop(self) -> str | None:
        while self._is_running and not hooks.is_shutdown():
            outcome = self._update_once()
            if outcome is not None:
                return outcome
        return None

    def _set_current_state(self, label: str | None) -> None:
        self._current_label = label
        if label is None:
            self._current_state = self._current_transitions = None
        else:
            self._current_state = self._states[label]
            self._current_transitions = self._transitions[label]

    def _update_once(self) -> str | None:
        """Execute the current state and follow its outcome; return the machine's outcome at the end."""
        label, state, states = self._current_label, self._current_state, self._states
        if label not in states:
            raise InvalidStateError(f"There is no state {label!r} in the machine: {list(states)}")
        if self._preempt_requested:
            self._pass_on_preempt()
        if label in self._constants:
            for key, value in self._constants[label].items():
                self.userdata[key] = value
        view = self._view(state, self._remappings[label])
        lock = self._state_transitioning_lock
        lock.release()  # so that a preempt can be requested meanwhile
        try:
            outcome = state.execute(view)
        except Exception as error:
            if isinstance(error, InvalidUserCodeError):
                hooks.logerr(f"State {label!r} failed to execute.")
                raise error
            trace = "".join(traceback.format_exception(error))
            raise InvalidUserCodeError(
                f"Could not execute state {label!r} of type {type(state).__name__}: {trace}"
            ) from error
        finally:
            lock.acquire()
        if self._current_state is not state:  # it executed its own machine; upstream stumbles below, over None
            label, state = self._current_label, self._current_state
        registered = state.get_registered_outcomes()
        if outcome not in registered:
            raise InvalidTransitionError(
                f"State {label!r} returned {outcome!r}, but its outcomes are {list(registered)}"
            )
        transitions: Any = self._current_transitions
        if outcome not in transitions:
            raise InvalidTransitionError(f"Outcome {outcome!r} of state {label!r} has no transition: {transitions}")
        target = transitions[outcome]
        if target not in states:
            return self._terminate(label, state, outcome, target)
        self._set_current_state(target)
        hooks.loginfo(f"State machine transitioning '{label}':'{outcome}'-->'{target}'")
        self.call_transition_cbs()
        return None

    def _terminate(self, label: Any, state: Any, outcome: str, target: str | None) -> str:
        if self._preempt_requested and self._preempted_state is not None:
            if not state.preempt_requested():
                self.service_preempt()
        outcomes = self.get_registered_outcomes()
        reached = target if target in outcomes else outcome
        if reached not in outcomes:
            raise self._leads_nowhere(label, outcome, target)
        self._set_current_state(None)
        hooks.loginfo(f"State machine terminating {label!r}:{outcome!r}:{reached!r}")
        self.call_termination_cbs([label], reached)
        return reached

    def _pass_on_preempt(self) -> None:
        """Before a state is executed: bring a request of the machine to it, or see that the last state obeyed."""
        if self._preempted_state is None:
            self._preempt_current_state()
        elif self._preempted_state.preempt_requested():
            if self._preempted_state is not self._current_state:  # in a self-loop the flag just stays
                self._preempted_state.recall_preempt()
                self._preempt_current_state()
        else:
            self._preempt_requested = False
            self._preempted_state = None

    def _preempt_current_state(self) -> None:
        """Request a preempt of the current state, once while it is the same one."""
        state = self._current_state
        if state is None or state is self._preempted_state:
            return
        self._preempted_state, self._preempted_label = state, self._current_label
        try:
            state.request_preempt()
        except Exception:  # noqa: BLE001 - the machine goes on, as upstream
            hooks.logerr(f"Failed to preempt state {self._current_label!r}: {traceback.format_exc()}")

    def request_preempt(self) -> None:
        """Ask the machine, and with it the current state, to stop."""
        with self._state_transitioning_lock:
            self._preempt_requested = True
            self._preempt_current_state()

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "_state_transitioning_lock"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._state_transitioning_lock = threading.RLock()
