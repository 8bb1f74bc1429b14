"""Plain transitions of a compiled machine: from state to state without what only hand-written machines need.

The states of a compiled machine read no userdata and have no constants, and they return outcomes that they have. What
is left of a transition of SMACH is looked at each time: a preempt, a shutdown, somebody who listens, the tables.
"""

from __future__ import annotations

from typing import Any

from grip_bt import smach_compat
from grip_bt.smach_compat.log import silent
from grip_bt.smach_compat.util import is_shutdown

from .behaviour_state import TaskState

ORDINARY: Any = object()
"""The very next transition isn't plain; its state hasn't been executed."""


def go_on(machine: Any) -> Any:
    """Execute states of a machine as long as transitions are plain.

    The machine's lock is held by the caller and released meanwhile, so that a preempt can be requested. One that comes
    between two states is seen before the second: its writer sets the flag and then looks for the current state, while
    here the state is set and then the flag looked at.

    Args:
        machine: a `StateMachine` of smach_compat.

    Returns:
        The machine's outcome; `ORDINARY`; None after some transitions, before one that isn't plain or mustn't be.

    Raises:
        InvalidUserCodeError: a state raised.
    """
    if machine._constants or not all(isinstance(state, TaskState) for state in machine._states.values()):
        return ORDINARY
    lock, result = machine._state_transitioning_lock, ORDINARY
    lock.release()
    try:
        while True:
            label, state = machine._current_label, machine._current_state
            if (
                machine._preempt_requested
                or machine._transition_cbs
                or not machine._is_running
                or smach_compat.is_shutdown is not is_shutdown
                or smach_compat.loginfo is not silent
                or label not in machine._states
            ):
                return result
            try:
                outcome = state.execute(None)
            except Exception as error:  # noqa: BLE001 - it says which state it was, and goes on
                machine._raise_as_user_code(label, state, error)
            try:
                target = machine._current_transitions[outcome]
                following, transitions = machine._states[target], machine._transitions[target]
            except (KeyError, TypeError):
                break
            if machine._transition_cbs or machine._current_state is not state:
                break
            machine._current_label, machine._current_state = target, following
            machine._current_transitions, result = transitions, None
    finally:
        lock.acquire()
    return machine._follow(label, state, outcome, plain=True)
