"""Functions of the user that states call, each with the userdata keys that it may touch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from grip_bt import smach_compat as smach


@dataclass
class UserCode:
    """A callback: `cb(userdata, *values, *args, **kwargs)`; without function, calls give None.

    Attributes:
        cb: the function, or None.
        args: further arguments.
        kwargs: further named arguments.
        inputs: userdata that it reads.
        outputs: userdata that it writes.
    """

    cb: Any
    args: Iterable[Any]
    kwargs: Mapping[str, Any]
    inputs: Iterable[str]
    outputs: Iterable[str]

    def __call__(self, ud: Any, *values: Any) -> Any:
        """Call the function with a view of the userdata that has its keys."""
        if self.cb is None:
            return None
        return self.cb(smach.Remapper(ud, self.inputs, self.outputs, []), *values, *self.args, **self.kwargs)


def user_code(
    state: smach.State, what: str, cb: Any, args: Iterable[Any], kwargs: Mapping[str, Any], keys: tuple[Any, Any]
) -> UserCode:
    """Take a callback: its keys are those it declares, and then the state has them too, else the state's own.

    Args:
        state: who calls it.
        what: what it is, for the message.
        cb: the function, or None.
        args: further arguments.
        kwargs: further named arguments.
        keys: the state's input and output keys as given.

    Raises:
        InvalidStateError: it can't be called.
    """
    if cb and not callable(cb):
        raise smach.InvalidStateError(f"The {what} given to {type(state).__name__} is no function: {cb!r}")
    if not smach.has_smach_interface(cb):
        return UserCode(cb, args, kwargs, *keys)
    inputs, outputs = cb.get_registered_input_keys(), cb.get_registered_output_keys()
    state.register_input_keys(inputs)
    state.register_output_keys(outputs)
    return UserCode(cb, args, kwargs, inputs, outputs)
