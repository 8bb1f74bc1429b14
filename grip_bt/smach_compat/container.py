"""The base of everything that holds states: construction with `with container:`, callbacks, keys in and out.

One thread at a time has containers open, one inside the other: `StateMachine.add` and its kin work on the innermost.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from types import TracebackType
from typing import Any, ClassVar, TypeVar

from ._settings import hooks, quiet
from .exceptions import InvalidConstructionError, InvalidStateError, InvalidTransitionError
from .state import State
from .user_data import NOTHING, Remapper, Remapping, UserData

C = TypeVar("C", bound="Container")


class Container(State):
    """A state made of states; its `userdata` outlives an execution, and may be replaced."""

    _construction_stack: ClassVar[list[Container]] = []
    _construction_lock: ClassVar[Any] = threading.RLock()
    _context_kwargs: ClassVar[dict[str, object]] = {}

    def __init__(
        self,
        outcomes: Iterable[str] = NOTHING,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
    ):
        State.__init__(self, outcomes, input_keys, output_keys)
        self.userdata = UserData()
        self._start_cbs: list[tuple[Callable[..., Any], Iterable[Any]]] = []
        self._transition_cbs: list[tuple[Callable[..., Any], Iterable[Any]]] = []
        self._termination_cbs: list[tuple[Callable[..., Any], Iterable[Any]]] = []

    def __getitem__(self, key: str) -> State:
        return self.get_children()[key]

    def get_children(self) -> dict[str, State]:
        """Return label -> state."""
        raise NotImplementedError

    def set_initial_state(self, initial_states: list[str], userdata: UserData) -> None:
        """Say where the next execution begins, and add to its userdata."""
        raise NotImplementedError

    def get_initial_states(self) -> list[str]:
        """Return the labels at which it begins."""
        raise NotImplementedError

    def get_active_states(self) -> list[str]:
        """Return the labels of what is executed now."""
        raise NotImplementedError

    def get_internal_edges(self) -> list[tuple[str, str, str | None]]:
        """Return (outcome, label it leaves, label or container outcome it leads to)."""
        raise NotImplementedError

    def check_consistency(self) -> None:
        """Raise InvalidStateError or InvalidTransitionError when it can't be executed."""
        raise NotImplementedError

    def check_state_spec(self, label: str, state: State, transitions: Mapping[str, str | None]) -> None:
        """Check that a state has all the outcomes that its transitions name."""
        outcomes = state.get_registered_outcomes()
        unknown = [outcome for outcome in transitions if outcome not in outcomes]
        if unknown:
            raise InvalidTransitionError(
                f"Transitions of state {label!r} name {unknown}, but its outcomes are {list(outcomes)}"
            )

    def open(self) -> None:
        """Make it the container that `add` adds to; other threads that open one wait until it is closed."""
        # Upstream pushes before it has the lock, so that a waiting thread diverts the other's `add`, whose `close` then
        # fails and leaves both hanging.
        Container._construction_lock.acquire()
        Container._construction_stack.append(self)

    def close(self) -> None:
        """End construction and check it; an inconsistency is logged and not raised."""
        stack = Container._construction_stack
        if not stack or stack[-1] is not self:
            raise InvalidStateError(
                f"Attempting to close {self}, but the innermost open container is {stack[-1] if stack else None}"
            )
        self._pop()
        try:
            self.check_consistency()
        except (InvalidStateError, InvalidTransitionError):
            hooks.logerr("Container consistency check failed.")

    @staticmethod
    def _pop() -> None:
        Container._construction_stack.pop()
        Container._construction_lock.release()

    def is_opened(self) -> bool:
        """Tell whether it is open for construction."""
        return any(container is self for container in Container._construction_stack)

    def assert_opened(self, msg: str = "") -> None:
        """Raise InvalidConstructionError unless it is open."""
        if not self.is_opened():
            raise InvalidConstructionError(msg or f"{self} isn't open for construction")

    @classmethod
    def _currently_opened_container(cls: type[C]) -> C:
        stack = Container._construction_stack
        if not stack:
            raise InvalidStateError(f"No container is open: add states inside `with a_{cls.__name__.lower()}:`")
        if not isinstance(stack[-1], cls):
            raise InvalidStateError(
                f"The innermost open container is a {type(stack[-1]).__name__}, not a {cls.__name__}"
            )
        return stack[-1]

    def __enter__(self) -> None:
        self.open()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self.close()
            return
        if not isinstance(error, (InvalidStateError, InvalidTransitionError)) and hooks.logerr is not quiet:
            hooks.logerr("".join(traceback.format_exception(error)))
        innermost = False
        while not innermost and self.is_opened():  # whatever was opened inside and not closed, too
            innermost = Container._construction_stack[-1] is self
            self._pop()

    @contextmanager
    def opened(self: C, **kwargs: object) -> Iterator[C]:
        """Open it for the body of a `with`; unlike `with container:` this names it and always closes."""
        self.open()
        self._context_kwargs = kwargs  # type: ignore[misc]  # hides the class's empty one
        try:
            yield self
        finally:
            self._context_kwargs = {}  # type: ignore[misc]
            self.close()

    def register_start_cb(self, cb: Callable[..., object], cb_args: Iterable[object] = NOTHING) -> None:
        """Call `cb(userdata, initial_states, *cb_args)` when an execution begins."""
        self._start_cbs.append((cb, cb_args))

    def register_transition_cb(self, cb: Callable[..., object], cb_args: Iterable[object] = NOTHING) -> None:
        """Call `cb(userdata, active_states, *cb_args)` at each transition."""
        self._transition_cbs.append((cb, cb_args))

    def register_termination_cb(self, cb: Callable[..., object], cb_args: Iterable[object] = NOTHING) -> None:
        """Call `cb(userdata, terminal_states, outcome, *cb_args)` when an execution ends."""
        self._termination_cbs.append((cb, cb_args))

    def call_start_cbs(self) -> None:
        """Call the start callbacks."""
        if self._start_cbs:
            self._call("start", self._start_cbs, self.get_initial_states())

    def call_transition_cbs(self) -> None:
        """Call the transition callbacks."""
        if self._transition_cbs:
            self._call("transition", self._transition_cbs, self.get_active_states())

    def call_termination_cbs(self, terminal_states: object, outcome: str | None) -> None:
        """Call the termination callbacks."""
        if self._termination_cbs:
            self._call("termination", self._termination_cbs, terminal_states, outcome)

    def _call(self, kind: str, callbacks: list[Any], *args: object) -> None:
        try:
            for cb, cb_args in callbacks:
                cb(self.userdata, *args, *cb_args)
        except Exception:  # noqa: BLE001 - an observer must not end the execution; the rest is skipped as upstream
            hooks.logerr(f"Could not call a {kind} callback:\n{traceback.format_exc()}")

    def _view(self, state: State, remapping: Remapping) -> Remapper:
        return Remapper(self.userdata, state.get_registered_input_keys(), state.get_registered_output_keys(), remapping)

    def _copy_input_keys(self, parent_ud: UserData | Remapper | None, ud: UserData) -> None:
        if parent_ud is not None:
            _copy_keys(self.get_registered_input_keys(), parent_ud, ud, "input")

    def _copy_output_keys(self, ud: UserData, parent_ud: UserData | Remapper | None) -> None:
        if parent_ud is not None:
            _copy_keys(self.get_registered_output_keys(), ud, parent_ud, "output")


def _copy_keys(keys: Iterable[str], source: UserData | Remapper, target: UserData | Remapper, kind: str) -> None:
    for key in keys:
        try:
            target[key] = source[key]
        except KeyError:
            hooks.logwarn(f"No value for the declared {kind} key {key!r} of a container.")
