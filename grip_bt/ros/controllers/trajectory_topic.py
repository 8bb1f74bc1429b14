"""A joint trajectory controller by its topic: trajectories are published, and what becomes of them is measured.

The topic `~/joint_trajectory` of ros2_control's joint_trajectory_controller answers nothing: a trajectory that is
refused, or given up, is one that the joints don't follow.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence

import numpy as np

from grip_bt.commanders.trajectory.braking import accelerations_of, stop_ramp
from grip_bt.errors import CanceledError, ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.operation import Operation
from grip_bt.values import Trajectory

from ..bus import Bus
from ..convert_geometry import trajectory_to_message
from .joint_states import JointStates
from .motion import START_TOLERANCE, RosExecutor, settle

MESSAGE = "trajectory_msgs/msg/JointTrajectory"
END_TOLERANCE = 0.05
"""A motion has succeeded when the joints come to rest so near to its end [rad or m]."""
GENTLY = 0.8
"""Part of the joints' acceleration limits that braking uses: when the controller hears of it isn't known exactly."""
SOONEST = 0.05
"""Joints are told to rest no sooner than this after a message [s]."""
LOOK = 0.1
"""How often it is looked at whether the joints are still measured [s]."""
FOUND = 6.0
"""How long the controller may take to be there [s]."""


class TopicExecutor(RosExecutor):
    """Implements `grip_bt.ports.Executor` over the topic of a joint trajectory controller.

    A motion ends when the joints are measured to be at its end, or to stand still. Where that is elsewhere, it is
    aborted, and `data` has `stopped_short`: how far off.

    Args:
        bus: the connection to ROS.
        topic: the controller's, such as `/arm_controller/joint_trajectory`.
        names: its joints.
        states: where they are measured.
        accelerations: joint -> limit, for braking; see `trajectory.braking.accelerations_of`.
    """

    def __init__(
        self,
        bus: Bus,
        topic: str,
        names: Sequence[str],
        states: JointStates,
        accelerations: Mapping[str, float] | None = None,
    ):
        super().__init__(names, states)
        self._accelerations = accelerations or {}
        self._topic, self._writer, self._guard = topic, bus.writer(MESSAGE, topic), bus.guard

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        self._stop, self._dropped, self._left = stop, dropped, left = [threading.Event() for _ in range(3)]
        done: Operation[None] = Operation(on_cancel=stop.set)

        def follow() -> None:
            self._follow(trajectory, stop, dropped, done)
            left.set()

        threading.Thread(target=follow, name="grip_topic", daemon=True).start()
        return done

    def _drop(self) -> None:
        self._dropped.set()
        self._stop.set()
        self._left.wait(1.0)

    def _follow(
        self, trajectory: Trajectory, stop: threading.Event, dropped: threading.Event, done: Operation[None]
    ) -> None:
        try:
            if self._guard is not None:
                self._guard.follows(self._topic, self._names)
            sent = self._writer.publish(trajectory_to_message(trajectory), 1, FOUND)
            if not sent.wait(FOUND + 1.0):
                raise ServerTimeOutError(f"{self._topic}: nobody listens")
            sent.result()
            began = time.monotonic()
            while not stop.is_set() and (left := began + trajectory.duration - time.monotonic()) > 0:
                stop.wait(min(left, LOOK))
                self.state()  # a robot that is gone ends the motion
            if not stop.is_set():
                settle(self.state, trajectory.positions[-1][self._order(trajectory)], stop)
            if stop.is_set():
                if not dropped.is_set():
                    self._brake(trajectory, time.monotonic() - began)
                done.fail(CanceledError("the motion was stopped"))
            else:
                self._judge(trajectory, done)
        except (ServerTimeOutError, SensorError) as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)
        finally:
            if self._guard is not None:
                self._guard.free(self._topic)

    def _brake(self, trajectory: Trajectory, passed: float) -> None:
        """Publish where and when the joints are at rest: further on their path, or where they are off that.

        The controller goes there by a cubic from the position and the velocity that it has then, which for a ramp is
        even braking, and forgives that nobody knows exactly when it hears of it.
        """
        limits = GENTLY * accelerations_of(trajectory.names, self._accelerations)
        ramp = stop_ramp(trajectory, passed, limits)
        rest, within = ramp.positions[-1], max(ramp.duration, SOONEST)
        try:
            measured = self._states.state(trajectory.names).position
            if np.abs(measured - trajectory.at(passed)).max() > START_TOLERANCE:
                rest = measured
        except SensorError:
            pass  # to rest on the path is the best that is known then
        still = Trajectory(trajectory.names, np.zeros(1), rest[None], np.zeros((1, len(rest))))
        self._writer.publish(trajectory_to_message(still, within), 0)

    def _judge(self, trajectory: Trajectory, done: Operation[None]) -> None:
        off = np.abs(self._states.state(trajectory.names).position - trajectory.positions[-1])
        worst = int(off.argmax())
        if off[worst] <= END_TOLERANCE:
            done.succeed(None)
            return
        joint = trajectory.names[worst]
        reason = f"{self._topic}: joint {joint} stands {off[worst]:.3f} short of the end of the motion"
        hint = "the controller says why in its log: it refused it, gave it up, isn't active, or something is in the way"
        done.fail(ExecutionAbortedError(f"{reason}; {hint}", stopped_short=float(off[worst])))

    def _order(self, trajectory: Trajectory) -> list[int]:
        return [trajectory.names.index(name) for name in self._names]
