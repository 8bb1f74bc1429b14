"""A joint trajectory controller by its topic: trajectories are published, and what becomes of them is measured.

The topic `~/joint_trajectory` of ros2_control's joint_trajectory_controller answers nothing: a trajectory that is
refused, or given up, is one that the joints don't follow.
"""

from __future__ import annotations

import time
from contextlib import ExitStack

import numpy as np

from grip_bt.base.failures import ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.base.values import Trajectory
from grip_bt.commanders.trajectory.braking import stop_ramp

from ..convert_geometry import trajectory_to_message
from .motion import START_TOLERANCE, settle
from .over_topic import Course, OverTopic

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


class TopicExecutor(OverTopic[Course]):
    """Implements `grip_bt.base.ports.Executor` over the topic of a joint trajectory controller; see `OverTopic`.

    A motion ends when the joints are measured to be at its end, or to stand still. Where that is elsewhere, it is
    aborted, and `data` has `stopped_short`: how far off.
    """

    message = "trajectory_msgs/msg/JointTrajectory"

    def _course_of(self, trajectory: Trajectory) -> Course:
        return Course(trajectory)

    def _follow(self, course: Course) -> None:
        trajectory, stop = course.trajectory, course.stop
        with ExitStack() as stack:
            if self._guard is not None:
                self._guard.follows(self._topic, self._names)
                stack.callback(self._guard.free, self._topic)
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
            if not stop.is_set():
                self._judge(trajectory)
            elif not course.dropped.is_set():
                self._brake(trajectory, time.monotonic() - began)

    def _brake(self, trajectory: Trajectory, passed: float) -> None:
        """Publish where and when the joints are at rest: further on their path, or where they are off that.

        The controller goes there by a cubic from the position and the velocity that it has then, which for a ramp is
        even braking, and forgives that nobody knows exactly when it hears of it.
        """
        ramp = stop_ramp(trajectory, passed, GENTLY * self._limits(trajectory))
        rest, within = ramp.positions[-1], max(ramp.duration, SOONEST)
        try:
            measured = self._states.state(trajectory.names).position
            if np.abs(measured - trajectory.at(passed)).max() > START_TOLERANCE:
                rest = measured
        except SensorError:
            pass  # to rest on the path is the best that is known then
        still = Trajectory(trajectory.names, np.zeros(1), rest[None], np.zeros((1, len(rest))))
        self._writer.publish(trajectory_to_message(still, within), 0)

    def _judge(self, trajectory: Trajectory) -> None:
        """Raise ExecutionAbortedError where the joints aren't at the end."""
        off = np.abs(self._states.state(trajectory.names).position - trajectory.positions[-1])
        worst = int(off.argmax())
        if off[worst] <= END_TOLERANCE:
            return
        joint = trajectory.names[worst]
        reason = f"{self._topic}: joint {joint} stands {off[worst]:.3f} short of the end of the motion"
        hint = "the controller says why in its log: it refused it, gave it up, isn't active, or something is in the way"
        raise ExecutionAbortedError(f"{reason}; {hint}", stopped_short=float(off[worst]))
