"""`State`, what does the work in a machine, and `CBState`, one made of a function."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from .user_data import NOTHING
from .util import Interface, OrderedSet, has_smach_interface


class State(Interface):
    """A piece of work that ends with one of its outcomes."""

    def __init__(
        self,
        outcomes: Iterable[str] = NOTHING,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
        io_keys: list[str] = NOTHING,
    ):
        self._outcomes = OrderedSet(outcomes)
        self._input_keys = OrderedSet(input_keys + io_keys)
        self._output_keys = OrderedSet(output_keys + io_keys)
        self._preempt_requested = False

    def execute(self, ud: Any) -> Any:
        """Do the work, which may block, and return one of the outcomes."""
        raise NotImplementedError(f"{type(self).__name__}.execute")

    def register_outcomes(self, new_outcomes: Iterable[str]) -> None:
        self._outcomes = self._outcomes.union(new_outcomes)

    def register_io_keys(self, keys: Iterable[str]) -> None:
        self._input_keys = self._input_keys.union(keys)
        self._output_keys = self._output_keys.union(keys)

    def register_input_keys(self, keys: Iterable[str]) -> None:
        self._input_keys = self._input_keys.union(keys)

    def register_output_keys(self, keys: Iterable[str]) -> None:
        self._output_keys = self._output_keys.union(keys)

    # The flag is no more than a flag: nothing resets it on entry or exit, the state that obeys it does.

    def request_preempt(self) -> None:
        self._preempt_requested = True

    def service_preempt(self) -> None:
        self._preempt_requested = False

    def recall_preempt(self) -> None:
        self._preempt_requested = False

    def preempt_requested(self) -> bool:
        return self._preempt_requested


class CBState(State):
    """A state whose work is `cb(userdata, *cb_args, **cb_kwargs)`.

    Outcomes and keys that the function declares with `cb_interface` are added to the given ones.
    """

    def __init__(
        self,
        cb: Callable[..., str],
        cb_args: Iterable[object] = NOTHING,
        cb_kwargs: Mapping[str, Any] | None = None,
        outcomes: Iterable[str] = NOTHING,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
        io_keys: list[str] = NOTHING,
    ):
        super().__init__(outcomes, input_keys, output_keys, io_keys)
        self._cb = cb
        self._cb_args = cb_args
        self._cb_kwargs = {} if cb_kwargs is None else cb_kwargs
        if has_smach_interface(cb):
            self.register_input_keys(cb.get_registered_input_keys())  # type: ignore[attr-defined]
            self.register_output_keys(cb.get_registered_output_keys())  # type: ignore[attr-defined]
            self.register_outcomes(cb.get_registered_outcomes())  # type: ignore[attr-defined]

    def execute(self, ud: Any) -> Any:
        """Call the function."""
        return self._cb(ud, *self._cb_args, **self._cb_kwargs)
