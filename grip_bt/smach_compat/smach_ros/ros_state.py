"""States with a node, as the ROS 2 branch has them; in ROS 1's style they have none."""

from __future__ import annotations

import queue
import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from grip_bt.smach_compat._settings import hooks, settings
from grip_bt.smach_compat.exceptions import InvalidStateError, InvalidUserCodeError
from grip_bt.smach_compat.state import State
from grip_bt.smach_compat.user_data import NOTHING, Remapper
from grip_bt.smach_compat.util import has_smach_interface

from ._connection import ros, seconds, with_optional_node

__all__ = ["ConditionState", "MonitorState", "RosState"]

PERIOD = 0.05
"""How long to wait between two checks of a condition when nothing else was asked for [s]."""
_WAKE = object()


class RosState(State):
    """A state that may have an rclpy node, first or by name; none in ROS 1's style."""

    @with_optional_node
    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)

    @property
    def node(self) -> Any:
        return self._node  # type: ignore[attr-defined]

    def _full_name(self, name: str) -> str:
        return ros().name_of(name, self.node)


class ConditionState(RosState):
    """Ends with `true` as soon as `cond_cb(userdata)` holds, with `false` after the checks, or `preempted`.

    `poll_rate` is the time between two checks (a duration or [s]), in profile `ros2` checks per second. Noetic checks
    once more than `max_checks`; -1: for ever.
    """

    @with_optional_node
    def __init__(
        self,
        cond_cb: Callable[[Any], Any],
        input_keys: list[str] = NOTHING,
        poll_rate: Any = None,
        timeout: Any = None,
        max_checks: int = 1,
    ):
        State.__init__(self, outcomes=["true", "false", "preempted"], input_keys=input_keys)
        self._cond_cb = cond_cb
        if hasattr(cond_cb, "get_registered_input_keys") and hasattr(cond_cb, "get_registered_output_keys"):
            self.register_input_keys(cond_cb.get_registered_input_keys())
            self.register_output_keys(cond_cb.get_registered_output_keys())
        self._poll_rate, self._timeout, self._max_checks = poll_rate, timeout, max_checks

    def execute(self, ud: Any) -> str:
        clock = ros()
        limit = None if self._timeout is None else clock.now() + seconds(self._timeout)
        allowed = self._max_checks + (0 if settings.ros2 else 1)
        checks = 0
        while self._max_checks == -1 or checks < allowed:
            if limit is not None and clock.now() > limit:
                break
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
            try:
                if self._cond_cb(ud):
                    return "true"
            except Exception as error:
                raise InvalidUserCodeError(f"The condition {self._cond_cb} raised: {traceback.format_exc()}") from error
            checks += 1
            clock.sleep(self._period())
        return "false"

    def _period(self) -> float:
        if self._poll_rate is None:
            return PERIOD
        given = seconds(self._poll_rate)
        is_rate = settings.ros2 and isinstance(self._poll_rate, (int, float))
        return 1.0 / given if is_rate else given


class MonitorState(RosState):
    """Watches until a condition doesn't hold.

    Ends with `invalid` at the first message for which `cond_cb(userdata, message)` isn't true or raises, with `valid`
    at message number `max_checks` (-1: never), or with `preempted`. The condition may take its time.
    """

    @with_optional_node
    def __init__(
        self,
        topic: str,
        msg_type: Any,
        cond_cb: Callable[[Any, Any], Any],
        max_checks: int = -1,
        input_keys: list[str] = NOTHING,
        output_keys: list[str] = NOTHING,
    ):
        State.__init__(self, ["valid", "invalid", "preempted"], input_keys, output_keys)
        self._topic, self._msg_type, self._cond_cb, self._max_checks = topic, msg_type, cond_cb, max_checks
        self._messages: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def execute(self, ud: Any) -> str:
        """Subscribe, judge messages until it is decided, unsubscribe."""
        if not self.preempt_requested():
            self._messages = queue.SimpleQueue()
            subscription = ros().subscribe(self._full_name(self._topic), self._msg_type, self._messages.put)
            try:
                outcome = self._judge(ud)
            finally:
                subscription.close()
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        return outcome

    def _judge(self, ud: object) -> str:
        number = 0
        while not self.preempt_requested():
            message = self._messages.get()
            if message is _WAKE:
                continue
            number += 1
            if 0 < self._max_checks <= number:
                return "valid"
            try:
                holds = self._cond_cb(ud, message)
            except Exception as error:  # noqa: BLE001 - upstream: a condition that raises doesn't hold
                hooks.logerr(f"The condition {self._cond_cb} on {self._topic} raised: {error!r}")
                holds = False
            if not holds:
                return "invalid"
        return "preempted"

    def request_preempt(self) -> None:
        """Ask it to stop waiting."""
        super().request_preempt()
        self._messages.put(_WAKE)


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
    """Take a callback: its keys are those it declares, and then the state has them too, else the state's own."""
    if cb and not callable(cb):
        raise InvalidStateError(f"The {what} given to {type(state).__name__} isn't a function: {cb!r}")
    if not has_smach_interface(cb):
        return UserCode(cb, args, kwargs, *keys)
    inputs, outputs = cb.get_registered_input_keys(), cb.get_registered_output_keys()
    state.register_input_keys(inputs)
    state.register_output_keys(outputs)
    return UserCode(cb, args, kwargs, inputs, outputs)


class BadAnswerError(Exception):
    """A callback raised, or returned what is no outcome of its state."""


def answer_of(state: State, what: str, cb: UserCode, ud: object, *values: object) -> str | None:
    """Call a callback that may choose its state's outcome; return that, or None when it leaves it to the state."""
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


Part = tuple[str | None, list[str], Any, Iterable[Any], Mapping[str, Any] | None]
"""Of what is sent, or of the answer: the key of the whole, those of its fields, the callback, and its arguments."""


class AskingState(RosState):
    """Asks a server, with what comes from userdata and a callback, and hands the answer to another and to userdata."""

    def _take(self, names: tuple[str, str], sent: Part, answer: Part, keys: tuple[Any, Any], outcomes: Any) -> None:
        """Take what both have; `names`: of the callbacks."""
        State.__init__(self, outcomes=["succeeded", "aborted", "preempted"])
        self._sent, self._answer = (
            (key, slots, user_code(self, name, cb, args, kwargs or {}, keys))
            for name, (key, slots, cb, args, kwargs) in zip(names, (sent, answer), strict=True)
        )
        if has_smach_interface(answer[2]):
            self.register_outcomes(answer[2].get_registered_outcomes())
        self.register_input_keys([*([sent[0]] if sent[0] is not None else []), *sent[1], *keys[0]])
        self.register_output_keys([*([answer[0]] if answer[0] is not None else []), *answer[1], *keys[1]])
        self.register_outcomes(outcomes)

    def _made(self, ud: Any, message: Any) -> Any:
        """Return what is sent; BadAnswerError says why there is nothing, KeyError which userdata is missing."""
        key, slots, callback = self._sent
        if key is not None:
            message = ud[key]
        for slot in slots:
            setattr(message, slot, ud[slot])
        try:
            changed = callback(ud, message)
        except Exception:  # noqa: BLE001 - upstream: the state ends as aborted
            raise BadAnswerError(f"its callback raised: {traceback.format_exc()}") from None
        if changed is None and message is None:
            raise BadAnswerError("it is None")
        return message if changed is None else changed

    def _hand_over(self, what: str, ud: Any, answer: Any, *values: object) -> str | None:
        """Hand an answer over; return the outcome that the callback, called with `values`, has chosen."""
        key, slots, callback = self._answer
        chosen = answer_of(self, what, callback, ud, *values)
        if key is not None:
            ud[key] = answer
        for slot in slots if answer is not None else ():
            ud[slot] = getattr(answer, slot)
        return chosen
