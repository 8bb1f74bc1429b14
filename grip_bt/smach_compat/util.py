"""The check for shutdown, and outcomes and keys on plain functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from grip_bt.smach_compat._settings import hooks
from grip_bt.smach_compat._settings import is_shutdown as is_shutdown

from ._names import Interface, OrderedSet
from .user_data import NOTHING


def set_shutdown_check(cb: Callable[[], bool]) -> None:
    """Ask `cb()` before each state whether to stop."""
    hooks.is_shutdown = cb


def has_smach_interface(obj: object) -> bool:
    """Tell whether an object declares outcomes, input keys and output keys."""
    return all(hasattr(obj, name) for name in vars(Interface) if name.startswith("get_registered"))


class CBInterface(Interface):
    """A function together with outcomes and keys. `io_keys` are accepted and have no effect, as upstream."""

    def __init__(
        self,
        cb: Callable[..., object],
        outcomes: Iterable[str] = NOTHING,
        input_keys: Iterable[str] = NOTHING,
        output_keys: Iterable[str] = NOTHING,
        io_keys: Iterable[str] = NOTHING,
    ):
        self._cb = cb
        self._outcomes = OrderedSet(outcomes)
        self._input_keys = OrderedSet(input_keys)
        self._output_keys = OrderedSet(output_keys)

    def __call__(self, *args: object, **kwargs: object) -> object:
        return self._cb(*args, **kwargs)


class cb_interface:
    """Decorate a function with outcomes and keys: `@cb_interface(outcomes=["done"], input_keys=["x"])`."""

    def __init__(
        self,
        outcomes: Iterable[str] = NOTHING,
        input_keys: Iterable[str] = NOTHING,
        output_keys: Iterable[str] = NOTHING,
    ):
        self._outcomes, self._input_keys, self._output_keys = outcomes, input_keys, output_keys

    def __call__(self, cb: Callable[..., object]) -> CBInterface:
        return CBInterface(cb, self._outcomes, self._input_keys, self._output_keys)
