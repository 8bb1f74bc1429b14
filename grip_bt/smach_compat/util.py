"""The check for shutdown, and sets of outcomes and keys: of states, and on plain functions.

Legacy code touches the sets of a state directly (`state._outcomes.add(...)`, differences), so each has to be a `set`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from grip_bt.smach_compat._settings import hooks
from grip_bt.smach_compat._settings import is_shutdown as is_shutdown

from .user_data import NOTHING


class OrderedSet(set[Any]):
    """A set that iterates in the order in which names were added first."""

    # Whatever adds is overridden, so that `_order` has every name; what only removes is left to `set`.

    def __init__(self, names: Iterable[object] = ()):
        self._order: dict[object, None] = dict.fromkeys(names)
        super().__init__(self._order)

    def __iter__(self) -> Iterator[Any]:
        if len(self._order) == len(self):
            return iter(self._order)
        return iter([name for name in self._order if name in self])

    def add(self, name: object) -> None:
        self._order.setdefault(name)
        super().add(name)

    def update(self, *others: Iterable[Any]) -> None:
        for names in others:
            for name in names:
                self.add(name)

    def __ior__(self, other: Any) -> OrderedSet:  # type: ignore[misc]  # `|` still gives a plain set
        self.update(other)
        return self

    def symmetric_difference_update(self, other: Iterable[object]) -> None:
        for name in dict.fromkeys(other):
            (self.discard if name in self else self.add)(name)

    def __ixor__(self, other: Any) -> OrderedSet:  # type: ignore[misc]
        self.symmetric_difference_update(other)
        return self

    def union(self, *others: Iterable[object]) -> OrderedSet:
        """Return a new set: these names, then the others'."""
        result = OrderedSet(self)
        result.update(*others)
        return result

    def __reduce__(self) -> tuple[object, ...]:
        return (OrderedSet, (list(self),))


class Interface:
    """What declares outcomes and userdata keys."""

    _outcomes: OrderedSet
    _input_keys: OrderedSet
    _output_keys: OrderedSet

    def get_registered_outcomes(self) -> tuple[str, ...]:
        return tuple(self._outcomes)

    def get_registered_input_keys(self) -> tuple[str, ...]:
        return tuple(self._input_keys)

    def get_registered_output_keys(self) -> tuple[str, ...]:
        return tuple(self._output_keys)


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
