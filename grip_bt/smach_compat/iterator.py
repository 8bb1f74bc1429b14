"""`Iterator`: one state, once for each item."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable
from typing import Any

from grip_bt.smach_compat._settings import hooks

from .container import Container
from .exceptions import InvalidStateError, InvalidUserCodeError
from .state import State
from .user_data import NOTHING, Remapper, UserData


class Iterator(Container):
    """A container that executes its one state for each item, until an outcome breaks the loop.

    `it` is the items, or returns them when an execution begins; the exhausted outcome is added to the list `outcomes`.
    """

    def __init__(
        self,
        outcomes: list[str],
        input_keys: list[str],
        output_keys: list[str],
        it: Iterable[object] | Callable[[], Iterable[object]] = NOTHING,
        it_label: str = "it_data",
        exhausted_outcome: str = "exhausted",
    ):
        if exhausted_outcome not in outcomes:
            outcomes.append(exhausted_outcome)
        Container.__init__(self, outcomes, input_keys, output_keys)
        self._items = it
        self._items_label = it_label
        self._exhausted_outcome = exhausted_outcome
        self._state_label = ""
        self._state: State | None = None
        self._loop_outcomes: list[str] = []
        self._break_outcomes: list[str] = []
        self._final_outcome_map: dict[str, str] = {}
        self._is_running = False

    def set_iteritems(self, it: Iterable[object] | Callable[[], Iterable[object]], it_label: str) -> None:
        """Set the items, or the function that returns them, and the key of the current item."""
        self._items, self._items_label = it, it_label

    @staticmethod
    def set_contained_state(
        label: str,
        state: State,
        loop_outcomes: Iterable[str] = NOTHING,
        break_outcomes: Iterable[str] = NOTHING,
        final_outcome_map: dict[str, str] | None = None,
    ) -> None:
        """Set the state of the open iterator; it gets the iterator's userdata itself, with no check of keys.

        `loop_outcomes` are ignored where `break_outcomes` are given. With neither, every outcome ends the loop.
        """
        self = Iterator._currently_opened_container()
        self._state_label, self._state = label, state
        self._final_outcome_map = {} if final_outcome_map is None else final_outcome_map
        registered = state.get_registered_outcomes()
        # A second call adds to what the first one derived, as upstream.
        if break_outcomes:
            self._break_outcomes = list(break_outcomes)
            self._loop_outcomes += [o for o in registered if o not in self._break_outcomes]
        else:
            self._loop_outcomes = list(loop_outcomes)
            self._break_outcomes += [o for o in registered if o not in self._loop_outcomes]

    def check_consistency(self) -> None:
        if self._state is None:
            raise InvalidStateError("The iterator has no contained state")

    def get_children(self) -> dict[str, State]:
        return {} if self._state is None else {self._state_label: self._state}

    def set_initial_state(self, initial_states: list[str], userdata: UserData | None = None) -> None:
        """Take over `userdata`; there is only one state to begin with."""
        if any(label != self._state_label for label in initial_states):
            hooks.logwarn(f"An iterator begins with its state; {initial_states} is ignored.")
        if userdata is not None:
            self.userdata.update(userdata)

    def get_initial_states(self) -> list[str]:
        return [self._state_label]

    def get_active_states(self) -> list[str]:
        """Return the label of the state while it is executed."""
        return [self._state_label] if self._is_running else []

    def get_internal_edges(self) -> list[tuple[str, str, str | None]]:
        """Return (outcome, label, label or outcome of the iterator)."""
        label, final = self._state_label, self._final_outcome_map
        edges: list[tuple[str, str, str | None]] = [(o, label, label) for o in self._loop_outcomes]
        return edges + [(o, label, final.get(o, o)) for o in self._break_outcomes]

    def execute(self, parent_ud: UserData | Remapper | None = None) -> Any:
        """Execute the state for each item; what ended the loop, by `final_outcome_map`, isn't checked here."""
        self._is_running = True  # stays so after an exception, as upstream
        self._copy_input_keys(parent_ud, self.userdata)
        self.call_start_cbs()
        outcome = self._loop(self._items() if callable(self._items) else self._items)
        outcome = self._final_outcome_map.get(outcome, outcome)
        self._is_running = False
        hooks.loginfo(f"Iterator terminating with outcome {outcome!r}")
        self.call_termination_cbs(self._state_label, outcome)  # a string, not a list: as upstream
        self._copy_output_keys(self.userdata, parent_ud)
        return outcome

    def _loop(self, items: Iterable[object]) -> Any:
        outcome: Any = self._exhausted_outcome
        iterator = iter(items)
        while not hooks.is_shutdown():
            try:
                item = next(iterator)
            except Exception:  # noqa: BLE001 - items that fail count as used up, as upstream
                return self._exhausted_outcome
            self.userdata[self._items_label] = item
            outcome = self._execute_state()
            if self._preempt_requested or self._breaks(outcome):
                self._preempt_requested = False
                return outcome
            self.call_transition_cbs()
        return outcome

    def _breaks(self, outcome: str) -> bool:
        loop = self._loop_outcomes
        return outcome in self._break_outcomes or (bool(loop) and outcome not in loop)

    def _execute_state(self) -> str:
        try:
            outcome: str = self._state.execute(self.userdata)  # type: ignore[union-attr]
            return outcome
        except InvalidUserCodeError:
            hooks.logerr(f"State {self._state_label!r} failed to execute.")
            raise
        except Exception as error:
            raise InvalidUserCodeError(
                f"Could not execute state {self._state_label!r}: {traceback.format_exc()}"
            ) from error

    def request_preempt(self) -> None:
        """Ask the iterator to stop after this item, and the state too while it is executed."""
        self._preempt_requested = True
        if self._is_running and self._state is not None:
            self._state.request_preempt()
