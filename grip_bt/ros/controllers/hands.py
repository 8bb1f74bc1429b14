"""Hands behind the port `HandPort`, by a gripper's action or by any executor; and what sensors feel, on topics."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from functools import reduce
from re import findall
from typing import Any

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ExecutionAbortedError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, HandPort
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import JointState
from grip_bt.commanders.trajectory.splines import eased, slowed
from grip_bt.task.catalog.ros_config import ControllerConfig, SignalConfig

from ..client.bus import Bus
from ..client.goal import GoalEnd
from ..client.types import load_type
from ..interfaces.build import ensure_package
from .joint_states import JointStates
from .motion import MovedJoints, measured
from .trajectory import LATE, as_motion

ACTION = "control_msgs/action/GripperCommand"
UNKNOWN_FORCE = 1.0
"""Force of a contact where none is measured [N]: that there is one, not how strong."""
STOPPED_SHORT = 0.05
"""A joint that stays this far from where it was sent [rad] was stopped by something."""
SHORT_SLIDING = 3e-3
"""The same of a joint that slides, and of grippers [m]."""
GAVE_WAY = 2e-3
"""Fingers that have moved further than this since something stopped them [m or rad] don't touch it any more."""


class GripperHand(MovedJoints):
    """Implements `grip_bt.base.ports.HandPort`.

    Args:
        action: the gripper's action, such as `/gripper_controller/gripper_cmd`.
        wait: how long to wait for the gripper to appear [s].
    """

    def __init__(self, bus: Bus, action: str, joint: str, states: JointStates, wait: float = 5.0):
        super().__init__((joint,), states)
        ensure_package("control_msgs")
        self._type = load_type(ACTION)
        self._client, self._action, self._wait = bus.action(self._type, action), action, wait
        self._force, self._stopped_at = 0.0, 0.0

    def move(
        self, posture: JointState, duration: float, torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        """Move to a posture with at most `torque_limit` or `force` [N or N m, as the gripper has it].

        The gripper decides how long that takes. It ends also when something stops the fingers. Cancelled or given up,
        it ends when they were measured at rest; see `RosExecutor.execute`.
        """
        goal = self._type.Goal()
        (goal.command.position,) = map(float, posture.ordered(self.joint_names))
        goal.command.max_effort = float(force or torque_limit or 0.0)
        self._force, self._wanted = 0.0, goal.command.position

        def begin() -> Operation[GoalEnd]:
            sent = self._client.send(goal, duration + LATE, self._wait)
            return as_motion(sent.then(_stalls_are_ends), self._action)

        return self._move(begin, self._ended)

    def contacts(self) -> Mapping[str, float]:
        """Return the gripper's effort when something has stopped its fingers, and they are still there."""
        if not self._force or abs(self.state().position[0] - self._stopped_at) > GAVE_WAY:
            return {}
        return {self.joint_names[0]: self._force}

    def _ended(self, ended: GoalEnd) -> Operation[JointState]:
        result = ended.result

        def note(state: JointState) -> Operation[JointState]:
            self._stopped_at = float(state.position[0])
            # Some grippers, such as the Panda's, say of a grasp that it has reached its goal.
            held = abs(self._stopped_at - self._wanted) > SHORT_SLIDING or (result.stalled and not result.reached_goal)
            self._force = (abs(result.effort) or UNKNOWN_FORCE) if held else 0.0
            return Operation.finished(state)

        return measured(self._states, self.joint_names).then(note)


def _stalls_are_ends(ended: GoalEnd) -> Operation[GoalEnd]:
    """Take a goal that was given up because the fingers were stopped for one that is over."""
    stalled = ended.status == "aborted" and ended.result.stalled
    return Operation.finished(GoalEnd("succeeded", ended.result) if stalled else ended)


SHORT = {"controller_code", "stopped_short"}
"""What the data of an aborted motion has one of, when the joints have moved towards its end."""


class ControlledHand:
    """Implements `grip_bt.base.ports.HandPort`.

    Without tactile sensors, what stops a joint short of its goal is a contact; its force is the joint's effort, where
    that is measured.

    Args:
        executor: moves the hand's joints. One that aborts because a finger was stopped has still moved.
        accelerations: joint -> limit, kept to by moving for longer [rad/s^2 or m/s^2]; any, for those it doesn't name.
        sliding: the joints that are prismatic.
    """

    def __init__(
        self, executor: Executor, accelerations: Mapping[str, float] | None = None, sliding: Collection[str] = ()
    ):
        self._executor, self.joint_names = executor, executor.joint_names
        self.state, self.stop = executor.state, executor.stop
        self._short = np.array([SHORT_SLIDING if n in sliding else STOPPED_SHORT for n in self.joint_names])
        known = accelerations or {}
        self._hardest = np.array([known.get(name, np.inf) for name in self.joint_names])
        self._goal: JointState | None = None

    def move(
        self, posture: JointState, duration: float, torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        """Move the fingers towards a posture; see `grip_bt.base.ports.HandPort`.

        A torque limit can't be given to a position controller: set it in the controller.

        Raises:
            ValueError: a force is asked for.
        """
        if force is not None:
            raise ValueError("this hand's controller takes positions and no forces: close it without `force`")
        names = self.joint_names
        start, goal = self.state().ordered(names), posture.ordered(names)
        self._goal = JointState(names, goal)
        moving = slowed(eased(names, start, goal, duration), np.full(len(names), np.inf), self._hardest)

        def steps() -> Steps[JointState]:
            try:
                reached: JointState = yield self._executor.execute(moving)
                return reached
            except ExecutionAbortedError as error:
                if SHORT & set(error.data):  # stopped short by contact is what closing is for
                    return self.state()
                raise

        return run_steps(steps())

    def contacts(self) -> Mapping[str, float]:
        """Return the joints that something has stopped short of the last posture, and their efforts."""
        if self._goal is None:
            return {}
        state = self.state()
        short = np.abs(self._goal.ordered(state.names) - state.position) > self._short
        efforts = np.full(len(state.names), UNKNOWN_FORCE) if state.effort is None else np.abs(state.effort)
        return {name: float(e) for name, e, s in zip(state.names, efforts, short, strict=True) if s}


class _Signal:
    def __init__(self, bus: Bus, config: SignalConfig, stale: float):
        self._config, self._stale, self._reader = config, stale, bus.reader(config.message, config.topic)
        self._reader.listen()

    def numbers(self) -> tuple[Any, Array]:
        """Return the last message, and the numbers of its field; SensorError: it is too old, or has none."""
        latest = self._reader.latest
        if latest is None or time.monotonic() - latest.time > self._stale:
            silent = f"nothing was heard within {self._stale:g} s; {self._reader.publishers()}"
            raise SensorError(f"{self._config.topic}: {silent}")
        try:
            return latest.message, _flat(reduce(_part, findall(r"\w+", self._config.field), latest.message))
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            what = f"{self._config.message} has no numbers in `{self._config.field}` ({error})"
            raise SensorError(f"{self._config.topic}: {what}") from None


def _part(whole: Any, key: str) -> Any:
    return whole[int(key)] if key.isdigit() else getattr(whole, key)


def _flat(part: Any) -> Array:
    if hasattr(part, "get_fields_and_field_types"):
        return np.concatenate([_flat(getattr(part, name)) for name in part.get_fields_and_field_types()])
    return np.atleast_1d(np.asarray(part, float))


class TopicTouch:
    """Implements `grip_bt.base.ports.Touch` as a hand's controller says; without topics, contacts are the port's."""

    def __init__(self, bus: Bus, hand: HandPort, config: ControllerConfig, stale: float):
        self._hand = hand
        self._contacts = {link: _Signal(bus, each, stale) for link, each in config.contacts.items()}
        self._slips = {link: _Signal(bus, each, stale) for link, each in config.slips.items()}

    def contacts(self) -> Mapping[str, float]:
        return _lengths(self._contacts) if self._contacts else self._hand.contacts()

    def slips(self) -> Mapping[str, float]:
        """Return link -> how fast something slides along it [m/s]."""
        if not self._slips:
            raise SensorError("no sensors of slip are named; add `slips` to this hand under `ros: controllers`")
        return _lengths(self._slips)


def _lengths(signals: Mapping[str, _Signal]) -> dict[str, float]:
    found = {link: float(np.linalg.norm(signal.numbers()[1])) for link, signal in signals.items()}
    return {link: length for link, length in found.items() if length}


class TopicWrench:
    """A force-torque sensor on a topic of geometry_msgs/msg/WrenchStamped."""

    def __init__(self, bus: Bus, topic: str, stale: float):
        self._signal = _Signal(bus, SignalConfig(topic=topic, field="wrench"), stale)

    def __call__(self) -> dict[str, Array]:
        """Return the frame, and force [N] and torque [N m] in its axes, shape (6,); SensorError: it is silent."""
        message, numbers = self._signal.numbers()
        return {message.header.frame_id: numbers}
