"""`Sequence`: a state machine in which one outcome leads from each state to the next."""

from __future__ import annotations

from collections.abc import Iterable

from grip_bt.smach_compat._settings import hooks

from .state import State
from .state_machine import StateMachine
from .user_data import NOTHING, Remapping


class Sequence(StateMachine):
    """A machine whose states follow each other by `connector_outcome`, in the order in which they were added."""

    def __init__(
        self,
        outcomes: Iterable[str],
        connector_outcome: str,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
    ):
        StateMachine.__init__(self, outcomes, input_keys, output_keys)
        self._connector_outcome = connector_outcome
        self._last_added_seq_label: str | None = None

    @staticmethod
    def add(  # type: ignore[override]  # upstream's has no constants
        label: str, state: State, transitions: dict[str, object] | None = None, remapping: Remapping | None = None
    ) -> State:
        """Add a state to the open sequence and lead the previous one to it, unless that one leads elsewhere."""
        self = Sequence._currently_opened_container()
        StateMachine.add(label, state, transitions, remapping)
        previous, self._last_added_seq_label = self._last_added_seq_label, label
        connector = self._connector_outcome
        if previous is not None and self._transitions[previous].get(connector) is None:
            self._transitions[previous][connector] = label
            if connector not in self._states[previous].get_registered_outcomes():
                hooks.logerr(f"State {previous!r} of a sequence has no outcome {connector!r} to lead on with.")
        return state
