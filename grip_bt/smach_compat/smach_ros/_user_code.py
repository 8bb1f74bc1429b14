"""Functions of the user that states call, each with the userdata keys that it may touch."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from grip_bt.smach_compat.exceptions import InvalidStateError
from grip_bt.smach_compat.state import State
from grip_bt.smach_compat.user_data import Remapper
from grip_bt.smach_compat.util import has_smach_interface


@dataclass
class UserCode:
    """A callback with the userdata that it may touch: `cb(userdata, *values, *args, **kwargs)`; without `cb`, None."""

    cb: Any
    args: Iterable[Any]
    kwargs: Mapping[str, Any]
    inputs: Iterable[str]
    outputs: Iterable[str]

    def __call__(self, ud: object, *values: object) -> Any:
        if self.cb is None:
            return None
        return self.cb(Remapper(ud, self.inputs, self.outputs, []), *values, *self.args, **self.kwargs)


def user_code(
    state: State, what: str, cb: Any, args: Iterable[object], kwargs: Mapping[str, object], keys: tuple[Any, Any]
) -> UserCode:
    """Take a callback: its keys are those it declares, and then the state has them too, else the state's own.

    Raises:
        InvalidStateError: it can't be called.
    """
    if cb and not callable(cb):
        raise InvalidStateError(f"The {what} given to {type(state).__name__} is no function: {cb!r}")
    if not has_smach_interface(cb):
        return UserCode(cb, args, kwargs, *keys)
    inputs, outputs = cb.get_registered_input_keys(), cb.get_registered_output_keys()
    state.register_input_keys(inputs)
    state.register_output_keys(outputs)
    return UserCode(cb, args, kwargs, inputs, outputs)


class BadAnswerError(Exception):
    """A callback raised, or returned what is no outcome of its state."""


def answer_of(state: State, what: str, cb: UserCode, ud: object, *values: object) -> str | None:
    """Call a callback that may choose its state's outcome; return that, or None when it leaves it to the state.

    Raises:
        BadAnswerError: it raised, or chose an outcome that the state doesn't have.
    """
    try:
        chosen: str | None = cb(ud, *values)
    except Exception:  # noqa: BLE001 - upstream: the state ends as aborted
        raise BadAnswerError(f"The {what} raised: {traceback.format_exc()}") from None
    if chosen is not None and chosen not in state.get_registered_outcomes():
        raise BadAnswerError(
            f"The {what} returned {chosen!r}, but the outcomes are {list(state.get_registered_outcomes())}; "
            f"declare it by outcomes=[...] of the state or of cb_interface"
        )
    return chosen
