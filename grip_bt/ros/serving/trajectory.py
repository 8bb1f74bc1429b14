"""An executor as a joint trajectory controller: the action `FollowJointTrajectory`, one goal after the other.

As ros2_control's joint_trajectory_controller does it: a goal begins when it is accepted, from where the joints are and
as fast as they move then, by a cubic spline through its points; one that comes while another is followed takes its
place, and the other is aborted.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse
from rclpy.task import Future
from scipy.interpolate import CubicHermiteSpline

from grip_bt.errors import CanceledError, GripError
from grip_bt.operation import Operation
from grip_bt.ports import Executor
from grip_bt.values import JointState, Trajectory

from ..bus import Bus
from ..convert_geometry import seconds
from ..definitions import provide
from ..types import load_type

ACTION = "control_msgs/action/FollowJointTrajectory"
STEP = 0.01
"""Trajectories are handed to the executor in steps of so long [s]."""
NEAR = 1e-3
"""A first point that is due sooner is where the motion begins [s]."""


class ServedController:
    """Serves one action; made, used and closed from any thread.

    Args:
        bus: the connection to ROS.
        action: such as `/arm_controller/follow_joint_trajectory`.
        executor: moves the joints.
    """

    def __init__(self, bus: Bus, action: str, executor: Executor):
        provide("control_msgs")
        self.action, self._bus, self._executor = action, bus, executor
        self._type = load_type(ACTION)
        self._lock = threading.Lock()
        self._newest: _Goal | None = None
        self._goals: dict[bytes, _Goal] = {}
        self._server: Any = None
        made = bus.post(self._make)
        made.wait()
        made.result()

    def close(self) -> None:
        """End a motion under way, and take no more goals."""
        self._executor.stop()
        self._bus.post(lambda: self._server.destroy()).wait(2.0)

    # --- on the bus's thread ---

    def _make(self) -> None:
        self._server = ActionServer(
            self._bus.node,
            self._type,
            self.action,
            execute_callback=self._ended,
            goal_callback=self._asked,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._cancel,
        )

    def _asked(self, goal: Any) -> GoalResponse:
        """Reject what can't be followed."""
        points, names = goal.trajectory.points, list(goal.trajectory.joint_names)
        times = [seconds(p.time_from_start) for p in points]
        rising = all(a < b for a, b in zip(times, times[1:], strict=False))
        whole = all(len(p.positions) == len(names) and np.isfinite(p.positions).all() for p in points)
        fits = set(names) == set(self._executor.joint_names) and len(names) == len(set(names))
        return GoalResponse.ACCEPT if points and fits and rising and whole and times[0] >= 0 else GoalResponse.REJECT

    def _accepted(self, handle: Any) -> None:
        goal = _Goal(handle, Future(executor=self._bus.node.executor))
        self._goals[bytes(handle.goal_id.uuid)] = self._newest = goal
        handle.execute()
        # Not on this thread: the executor may have to ask another process where the joints are.
        threading.Thread(target=self._follow, args=(goal,), name="grip_follow", daemon=True).start()

    async def _ended(self, handle: Any) -> Any:
        goal = self._goals.pop(bytes(handle.goal_id.uuid))
        error = await goal.future
        result = self._type.Result()
        if error is None:
            handle.succeed()
            return result
        result.error_code, result.error_string = result.PATH_TOLERANCE_VIOLATED, str(error)
        if isinstance(error, CanceledError) and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result

    def _cancel(self, handle: Any) -> CancelResponse:
        goal = self._goals.get(bytes(handle.goal_id.uuid))
        if goal is not None and goal.motion is not None:
            goal.motion.cancel()
        return CancelResponse.ACCEPT

    # --- on a goal's thread ---

    def _follow(self, goal: _Goal) -> None:
        with self._lock:
            if goal is not self._newest:  # threads come here in any order, and a later goal takes the place of this one
                goal.end(self._bus, CanceledError("a newer goal came"))
                return
            try:
                asked = goal.handle.request.trajectory
                path = continued(list(asked.joint_names), asked.points, self._executor.state())
                goal.motion = self._executor.execute(path)
            except (GripError, ValueError) as error:
                goal.end(self._bus, error)
                return
        if goal.handle.is_cancel_requested:
            goal.motion.cancel()
        motion = goal.motion
        motion.add_done_callback(lambda: goal.end(self._bus, _error_of(motion)))


class _Goal:
    """A goal that was accepted."""

    def __init__(self, handle: Any, future: Future):
        self.handle, self.future = handle, future
        self.motion: Operation[JointState] | None = None

    def end(self, bus: Bus, error: BaseException | None) -> None:
        bus.post(lambda: self.future.done() or self.future.set_result(error))


def _error_of(motion: Operation[Any]) -> BaseException | None:
    try:
        motion.result()
    except GripError as error:
        return error
    return None


def continued(names: Sequence[str], points: Sequence[Any], state: JointState) -> Trajectory:
    """Return a trajectory through given points that begins where the joints are, as fast as they move, in small steps.

    Args:
        names: the joints, in the order of the points.
        points: of the message; times from now, the first may be later than 0. Velocities that aren't given are those of
            a curve through the points that rests at its end.
        state: measured.
    """
    order = [names.index(name) for name in state.names]
    late = [point for point in points if seconds(point.time_from_start) > NEAR]
    if not late:  # only where it is to be at once
        late, times = [points[-1]], np.array([0.0, STEP])
    else:
        times = np.array([0.0, *(seconds(point.time_from_start) for point in late)])
    positions = np.array([state.position, *(np.array(point.positions)[order] for point in late)])
    now = np.zeros(len(state.names)) if state.velocity is None else state.velocity
    if all(len(point.velocities) == len(names) for point in late):
        velocities = np.array([now, *(np.array(point.velocities)[order] for point in late)])
    else:
        velocities = np.gradient(positions, times, axis=0)
        velocities[0], velocities[-1] = now, 0.0
    curve = CubicHermiteSpline(times, positions, velocities)
    steps = np.linspace(0.0, times[-1], max(2, int(np.ceil(times[-1] / STEP)) + 1))
    return Trajectory(state.names, steps, curve(steps), curve(steps, 1))
