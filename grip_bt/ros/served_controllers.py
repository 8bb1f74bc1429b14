"""Controllers as ros2_control has them: joint trajectory controllers, grippers, and the manager that switches them.

A goal begins when it is accepted, as ros2_control's joint_trajectory_controller does it, from where the joints are and
as fast as they move then, by a cubic spline through its points; one that comes while another is followed takes its
place, and the other is aborted. One that is cancelled ends as such when the joints have come to rest; until then its
owner hears, by feedback, where the joints should be and are.
"""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.task import Future

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, HandPort
from grip_bt.base.values import JointState, Trajectory
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.convert_values import seconds
from grip_bt.ros.interfaces.build import ensure_package

from .client.types import Message, load_type

ACTION = "control_msgs/action/FollowJointTrajectory"
AT_ONCE = 0.01
"""How long joints take that are to be elsewhere at once [s]."""
TELL = 0.05
"""How often feedback tells where the joints are [s]."""
NEAR = 1e-3
"""A first point that is due sooner is where the motion begins [s]."""


class Controller:
    """Serves one action; made, used and closed from any thread.

    Args:
        action: such as `/arm_controller/follow_joint_trajectory`.

    Attributes:
        active: whether it takes goals.
    """

    action_type: ClassVar[str]
    kind: ClassVar[str]

    def __init__(self, bus: Bus, action: str, executor: Executor | HandPort):
        ensure_package("control_msgs")
        self.action, self._bus, self._executor = action, bus, executor
        self.active = True
        self._type = load_type(self.action_type)
        self._lock = threading.Lock()
        self._newest: _Goal | None = None
        self._goals: dict[bytes, _Goal] = {}
        self._server = bus.ask(self._make)

    @property
    def joints(self) -> tuple[str, ...]:
        return self._executor.joint_names

    @property
    def name(self) -> str:
        return self.action.strip("/").rpartition("/")[0]

    def deactivate(self) -> None:
        """End a motion under way, and take no more goals until it is active again."""
        self.active = False
        self._executor.stop()

    def close(self) -> None:
        """End a motion under way, and take no more goals for good."""
        self.deactivate()
        self._bus.post(lambda: self._server.destroy()).wait(2.0)

    # --- on the bus's thread ---

    def _make(self) -> ActionServer:
        return ActionServer(
            self._bus.node,
            self._type,
            self.action,
            execute_callback=self._ended,
            goal_callback=self._asked,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._cancel,
        )

    def _asked(self, goal: Message) -> GoalResponse:
        return GoalResponse.ACCEPT if self.active and self._takes(goal) else GoalResponse.REJECT

    def _accepted(self, handle: ServerGoalHandle) -> None:
        turn: Operation[None] = Operation(on_cancel=lambda: None)  # it ends when the motion can begin
        goal = _Goal(handle, Future(executor=self._bus.node.executor), turn, turn.then(lambda _: self._begin(goal)))
        self._goals[bytes(handle.goal_id.uuid)] = self._newest = goal
        goal.motion.add_done_callback(partial(self._over, goal))
        handle.execute()
        # Not on this thread: the executor may have to ask another process where the joints are.
        threading.Thread(target=self._follow, args=(goal,), name="grip_follow", daemon=True).start()

    def _over(self, goal: _Goal) -> None:
        self._bus.post(lambda: goal.future.set_result(_error_of(goal.motion)))

    async def _ended(self, handle: ServerGoalHandle) -> Message:
        goal = self._goals[bytes(handle.goal_id.uuid)]
        error = await goal.future
        del self._goals[bytes(handle.goal_id.uuid)]
        result = self._type.Result()
        canceled = isinstance(error, CanceledError) and handle.is_cancel_requested
        self._explain(result, goal, error)
        if error is None:
            handle.succeed()
        elif canceled:
            handle.canceled()
        else:
            handle.abort()
        return result

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        goal = self._goals.get(bytes(handle.goal_id.uuid))
        if goal is None:
            return CancelResponse.REJECT  # it has ended
        goal.motion.cancel()
        return CancelResponse.ACCEPT

    # --- on a goal's thread ---

    def _follow(self, goal: _Goal) -> None:
        with self._lock:
            if goal is self._newest and goal.motion.cancel_asked:
                self._executor.stop()  # it has taken the place of another one all the same
            goal.turn.succeed(None)
        began = time.monotonic()
        while not goal.motion.wait(TELL):
            self._tell(goal, time.monotonic() - began)

    def _begin(self, goal: _Goal) -> Operation[JointState]:
        if goal is not self._newest:  # threads come here in any order, and a later goal takes the place of this one
            raise CanceledError("a newer goal came")
        return self._move(goal)

    @abstractmethod
    def _takes(self, goal: Message) -> bool:
        """Tell whether a goal can be followed."""

    @abstractmethod
    def _move(self, goal: _Goal) -> Operation[JointState]:
        """Begin to follow a goal."""

    @abstractmethod
    def _explain(self, result: Message, goal: _Goal, error: Exception | None) -> None:
        """Say in a result how a goal has ended."""

    @abstractmethod
    def _tell(self, goal: _Goal, passed: float) -> None:
        """Send feedback, some time after the motion began [s]."""


class TrajectoryController(Controller):
    """A joint trajectory controller."""

    action_type, kind = ACTION, "joint_trajectory_controller/JointTrajectoryController"
    _executor: Executor

    def _takes(self, goal: Message) -> bool:
        points, names = goal.trajectory.points, list(goal.trajectory.joint_names)
        times = [seconds(p.time_from_start) for p in points]
        rising = all(a < b for a, b in zip(times, times[1:], strict=False))
        whole = all(len(p.positions) == len(names) and np.isfinite(p.positions).all() for p in points)
        fits = set(names) == set(self._executor.joint_names) and len(names) == len(set(names))
        return bool(points and fits and rising and whole and times[0] >= 0)

    def _move(self, goal: _Goal) -> Operation[JointState]:
        asked = goal.handle.request.trajectory
        goal.path = continued(list(asked.joint_names), asked.points, self._executor.state())
        return self._follow_path(goal.path)

    def _follow_path(self, path: Trajectory) -> Operation[JointState]:
        return self._executor.execute(path)

    def _explain(self, result: Message, goal: _Goal, error: Exception | None) -> None:
        if error is None:
            return
        result.error_string = str(error)
        if not (isinstance(error, CanceledError) and goal.handle.is_cancel_requested):
            replaced = isinstance(error, CanceledError)
            result.error_code = result.INVALID_GOAL if replaced else result.PATH_TOLERANCE_VIOLATED

    def _tell(self, goal: _Goal, passed: float) -> None:
        try:
            now = self._executor.state()
        except GripError:
            return  # the motion ends of the same
        handle, path = goal.handle, goal.path
        feedback = self._type.Feedback(joint_names=list(path.names))
        feedback.header.stamp = self._bus.node.get_clock().now().to_msg()
        position, velocity, _ = path.sampled(np.array([passed]))
        measured = now.ordered(path.names)
        feedback.desired.positions, feedback.desired.velocities = position[0].tolist(), velocity[0].tolist()
        feedback.actual.positions, feedback.error.positions = measured.tolist(), (position[0] - measured).tolist()
        self._bus.post(lambda: handle.is_active and handle.publish_feedback(feedback))


SOON = 0.1
"""Fingers take so long at least [s]."""


class FingerController(TrajectoryController):
    """One without tolerances, of whose trajectories the end and the duration count: fingers press on what they meet."""

    _executor: HandPort  # type: ignore[assignment]

    def _follow_path(self, path: Trajectory) -> Operation[JointState]:
        return self._executor.move(JointState(path.names, path.positions[-1]), max(float(path.times[-1]), SOON))


CLOSE = 2e-3
"""A gripper that ends this far from its goal was stopped by something [m or rad]."""
STROKE_TIME = 1.0
"""How long a gripper takes to its goal [s]."""


class GripperController(Controller):
    """A gripper's controller: one joint, which stays where something stops it, and presses on."""

    action_type, kind = "control_msgs/action/GripperCommand", "position_controllers/GripperActionController"
    _executor: HandPort

    def _takes(self, goal: Message) -> bool:
        return bool(np.isfinite(goal.command.position) and 0 <= goal.command.max_effort < np.inf)

    def _move(self, goal: _Goal) -> Operation[JointState]:
        command = goal.handle.request.command
        wanted = JointState(self.joints, np.array([command.position]))
        return self._executor.move(wanted, STROKE_TIME, force=command.max_effort or None)

    def _explain(self, result: Message, goal: _Goal, error: Exception | None) -> None:
        self._measure(result, goal)

    def _tell(self, goal: _Goal, passed: float) -> None:
        handle, feedback = goal.handle, self._type.Feedback()
        if self._measure(feedback, goal):
            feedback.stalled = False  # it may still move
            self._bus.post(lambda: handle.is_active and handle.publish_feedback(feedback))

    def _measure(self, message: Message, goal: _Goal) -> bool:
        try:
            state = self._executor.state()
        except GripError:
            return False
        message.position = float(state.position[0])
        message.effort = 0.0 if state.effort is None else float(state.effort[0])
        message.reached_goal = abs(message.position - goal.handle.request.command.position) < CLOSE
        message.stalled = not message.reached_goal
        return True


class ControllerManager:
    """Serves `list_controllers` and `switch_controller` as ros2_control's manager does, for controllers by name."""

    services = ("/controller_manager/list_controllers", "/controller_manager/switch_controller")

    def __init__(self, bus: Bus, controllers: Sequence[Controller]):
        ensure_package("controller_manager_msgs")
        self._controllers = {each.name: each for each in controllers}
        self._state = load_type("controller_manager_msgs/msg/ControllerState")
        answers = {"ListControllers": self._list, "SwitchController": self._switch}
        types = {name: load_type(f"controller_manager_msgs/srv/{name}") for name in answers}

        def begin() -> None:
            for service, (name, answer) in zip(self.services, answers.items(), strict=True):
                bus.node.create_service(types[name], service, answer)

        bus.ask(begin)

    def _list(self, asked: Message, said: Message) -> Message:
        said.controller = [
            self._state(
                name=name,
                state="active" if each.active else "inactive",
                type=each.kind,
                claimed_interfaces=[f"{joint}/position" for joint in each.joints] if each.active else [],
                required_command_interfaces=[f"{joint}/position" for joint in each.joints],
            )
            for name, each in self._controllers.items()
        ]
        return said

    def _switch(self, asked: Message, said: Message) -> Message:
        on, off = list(asked.activate_controllers), list(asked.deactivate_controllers)
        unknown = [name for name in (*on, *off) if name not in self._controllers]
        if unknown and asked.strictness != asked.BEST_EFFORT:
            said.message = str(UnknownNameError("controller", unknown[0], self._controllers))
            return said
        for name in self._controllers.keys() & off:
            self._controllers[name].deactivate()
        for name in self._controllers.keys() & on:
            self._controllers[name].active = True
        said.ok = True
        return said


@dataclass
class _Goal:
    """A goal that was accepted, and the motion that follows it; a cancel may come before that is begun."""

    handle: ServerGoalHandle
    future: Future
    turn: Operation[None]
    motion: Operation[JointState]
    path: Trajectory = field(init=False)


def _error_of(motion: Operation[JointState]) -> Exception | None:
    try:
        motion.result()
    except (GripError, ValueError) as error:
        return error
    return None


def continued(names: Sequence[str], points: Sequence[Message], state: JointState) -> Trajectory:
    """Return a trajectory through given points that begins where the joints are, as fast as they move.

    Args:
        points: of the message; times from now, the first may be later than 0. Velocities that aren't given are those of
            a curve through the points that rests at its end.
    """
    order = [names.index(name) for name in state.names]
    late = [point for point in points if seconds(point.time_from_start) > NEAR]
    if not late:  # only where it is to be at once
        late, times = [points[-1]], np.array([0.0, AT_ONCE])
    else:
        times = np.array([0.0, *(seconds(point.time_from_start) for point in late)])
    positions = np.array([state.position, *(np.array(point.positions)[order] for point in late)])
    now = np.zeros(len(state.names)) if state.velocity is None else state.velocity
    if all(len(point.velocities) == len(names) for point in late):
        velocities = np.array([now, *(np.array(point.velocities)[order] for point in late)])
    else:
        velocities = np.gradient(positions, times, axis=0)
        velocities[0], velocities[-1] = now, 0.0
    return Trajectory(state.names, times, positions, velocities)
