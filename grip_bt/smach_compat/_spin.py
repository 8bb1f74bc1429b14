"""Plain transitions of a machine, one after the other, without what plain ones don't need.

A transition is plain where the state has no keys and no constants, nobody listens, logs or preempts, and the outcome
leads to another state. Whatever else comes up is left to the machine's own `_update_once`, which does the same, slower.
"""

from __future__ import annotations

from typing import Any

from grip_bt import smach_compat as smach

from ._settings import errors_of_user_code
from .log import silent
from .util import is_shutdown

OVER = object()
"""The next transition isn't plain, and its state hasn't been executed yet."""


def spin(machine: Any) -> Any:
    """Execute states as long as transitions are plain; return the machine's outcome, or `OVER`.

    The machine's lock is held by the caller and released meanwhile, so that a preempt can be requested. Everything that
    programs reach into (`_states`, `_transitions`, the current label) is read and written at each transition.
    """
    lock = machine._state_transitioning_lock
    callbacks = machine._transition_cbs
    rows: dict[Any, tuple[Any, ...]] = {}
    label, state = machine._current_label, machine._current_state
    if callbacks or machine._preempt_requested or smach.loginfo is not silent or smach.is_shutdown is not is_shutdown:
        return OVER
    outcome: Any = None
    row: Any = None
    lock.release()
    try:
        while True:
            if row is None:
                row = rows[label] = _row(machine, label, state)
            known, view, left, outcomes, transitions = row
            if (
                state is not known
                or left
                or state._input_keys
                or state._output_keys
                or machine._current_transitions is not transitions
            ):
                return OVER
            outcome = state.execute(view)
            if (
                callbacks
                or machine._preempt_requested
                or machine._current_state is not state
                or state._outcomes is not outcomes
                or smach.loginfo is not silent
                or smach.is_shutdown is not is_shutdown
                or not machine._is_running
            ):
                break
            try:
                target = transitions[outcome]
                state = machine._states[target]
                machine._current_transitions = machine._transitions[target]
            except (KeyError, TypeError):
                state = known
                break
            machine._current_label = label = target
            machine._current_state = state
            row = rows.get(label)
    except errors_of_user_code() as error:
        lock.acquire()
        try:
            machine._raise_as_user_code(label, state, error)
        finally:
            lock.release()
    finally:
        lock.acquire()
    return machine._follow(label, state, outcome, plain=True) or OVER


def _row(machine: Any, label: Any, state: Any) -> tuple[Any, ...]:
    """Return a state that can be executed without more ado, with its view and what mustn't change; or no state."""
    if label in machine._states and machine._states[label] is state and label not in machine._constants:
        view, plain = machine._views.get(label, state, machine.userdata, machine._remappings[label])
        transitions, outcomes = machine._transitions[label], state._outcomes
        if plain and outcomes.issuperset(transitions):
            return state, view, view.__dict__, outcomes, transitions
    return (None,) * 5
