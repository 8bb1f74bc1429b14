"""Plain transitions of a machine, one after the other, without what plain ones don't need.

A transition is plain where the state has no constants, nobody listens or preempts, and the outcome leads to another
state. Whatever else comes up is left to the machine's own `_update_once`, which does the same, slower.
"""

from __future__ import annotations

from typing import Any

from grip_bt import smach_compat as smach

from ._settings import errors_of_user_code
from .log import silent
from .util import is_shutdown

OVER: Any = object()
"""The next transition isn't plain; its state may be executed and hasn't been yet."""

STOPPED: Any = object()
"""The next state mustn't be executed."""


def spin(machine: Any) -> Any:
    """Execute states as long as transitions are plain.

    The machine's lock is held by the caller and released meanwhile, so that a preempt can be requested. Everything that
    programs reach into (`_states`, `_transitions`, `_remappings`, the current label, the states' sets) is read and
    written at each transition. A request that comes between two states is seen before the second one, because its
    writer sets the flag and then looks for the current state, while here the state is set and then the flag looked at.

    Returns:
        The machine's outcome; None after a transition that wasn't plain; `OVER`; `STOPPED`.
    """
    if machine._transition_cbs or machine._preempt_requested or machine._current_label not in machine._states:
        return OVER
    lock, views = machine._state_transitioning_lock, machine._views
    rows = views.rows
    outcome: Any = None
    label, state = machine._current_label, machine._current_state
    lock.release()
    try:
        while True:
            try:
                known, view, left, inputs, outputs, remapping, store = rows[label]
                if (
                    known is not state
                    or left
                    or inputs is not state._input_keys.frozen
                    or outputs is not state._output_keys.frozen
                    or remapping is not machine._remappings[label]
                    or store is not machine.userdata
                    or machine._preempt_requested
                    or label in machine._constants
                ):
                    return OVER
            except (KeyError, AttributeError):  # no view yet, or keys in an ordinary set
                return OVER
            try:
                outcome = state.execute(view)
            except errors_of_user_code() as error:
                machine._raise_as_user_code(label, state, error)
            if machine._current_state is not state or machine._transition_cbs:
                break
            try:
                target = machine._current_transitions[outcome]
                following, transitions = machine._states[target], machine._transitions[target]
                if outcome not in state._outcomes:
                    break
            except (KeyError, TypeError):
                break
            machine._current_label, machine._current_state = target, following
            machine._current_transitions = transitions
            if smach.loginfo is silent and smach.is_shutdown is is_shutdown:
                if not machine._is_running:
                    return STOPPED
                label, state = target, following
                continue
            smach.loginfo(f"State machine transitioning '{label}':'{outcome}'-->'{target}'")
            if not machine._is_running or smach.is_shutdown():
                return STOPPED
            label, state = machine._current_label, machine._current_state
            if label not in machine._states:
                return OVER
    finally:
        lock.acquire()
    return machine._follow(label, state, outcome, plain=True)
