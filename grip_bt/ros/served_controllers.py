"""Controllers as ros2_control has them: joint trajectory controllers, grippers, and the manager that switches them.

A goal begins when it is accepted, as ros2_control's joint_trajectory_controller does it, from where the joints are and
as fast as they move then, by a cubic spline through its points; one that comes while another is followed takes its
place, and the other is aborted. One that is cancelled ends as such when the joints have come to rest; until then its
owner hears, by feedback, where the joints should be and are. A trajectory on the topic beside the action is a goal that
nobody waits for.
"""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import ClassVar

import numpy as np
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.task import Future

from grip_bt.base.errors import GripError, UnknownNameError, listing
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
"""A first point that is due sooner is where the motion begins [s]; so far beyond limits is at them [rad or m]."""
Limits = Mapping[str, tuple[float, float]]


class Controller:
    """Serves one action; made, used and closed from any thread.

    Args:
        action: such as `/arm_controller/follow_joint_trajectory`.
        limits: joint -> the lowest and the highest position that it may be sent to [rad or m].

    Attributes:
        active: whether it takes goals.
        name: as the controller manager has it.
    """

    action_type: ClassVar[str]
    kind: ClassVar[str]

    def __init__(self, bus: Bus, action: str, executor: Executor | HandPort, limits: Limits):
        ensure_package("control_msgs")
        self.action, self._bus, self._executor, self.joints = action, bus, executor, executor.joint_names
        self._limits = limits
        self.active, self.name = True, action.strip("/").rpartition("/")[0]
        self._type = load_type(self.action_type)
        self._lock = threading.Lock()
        self._newest: _Goal | None = None
        self._goals: dict[bytes, _Goal] = {}
        self._server = bus.ask(self._make)

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
            goal_callback=lambda goal: GoalResponse.ACCEPT if self._takes(goal) else GoalResponse.REJECT,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._cancel,
        )

    def _takes(self, asked: Message) -> bool:
        refusal = self._refusal(asked) if self.active else "it is inactive"
        if refusal:
            self._bus.node.get_logger().warning(f"{self.name} refuses a goal: {refusal}")
        return not refusal

    def _accepted(self, handle: ServerGoalHandle) -> None:
        self._take(handle.request, handle)
        handle.execute()

    def _take(self, asked: Message, handle: ServerGoalHandle | None = None) -> None:
        turn: Operation[None] = Operation(on_cancel=lambda: None)  # it ends when the motion can begin
        future = Future(executor=self._bus.node.executor)
        goal = _Goal(asked, handle, future, turn, turn.then(lambda _: self._begin(goal)))
        self._newest = goal
        if handle is not None:
            self._goals[bytes(handle.goal_id.uuid)] = goal
        goal.motion.add_done_callback(lambda: self._bus.post(lambda: self._over(goal)))
        # Not on this thread: the executor may have to ask another process where the joints are.
        threading.Thread(target=self._follow, args=(goal,), name="grip_follow", daemon=True).start()

    def _over(self, goal: _Goal) -> None:
        error = None
        try:
            goal.motion.result()
        except (GripError, ValueError) as raised:
            error = raised
        if goal.handle is None and not isinstance(error, CanceledError | None):
            self._bus.node.get_logger().warning(f"{self.name} gives up: {error}")
        goal.future.set_result(error)

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
        while goal.handle is not None and not goal.motion.wait(TELL):
            with suppress(GripError):  # the motion ends of the same
                self._bus.post(partial(goal.tell, self._feedback(goal, time.monotonic() - began)))

    def _begin(self, goal: _Goal) -> Operation[JointState]:
        if goal is not self._newest:  # threads come here in any order, and a later goal takes the place of this one
            raise CanceledError("a newer goal came")
        return self._move(goal)

    def _beyond(self, names: Sequence[str], positions: Sequence[float]) -> str:
        for name, position in zip(names, positions, strict=True):
            low, high = self._limits.get(name, (position, position))
            if not low - NEAR <= position <= high + NEAR:
                return f"{name} can go from {low:.4g} to {high:.4g}, not to {position:.4g}"
        return ""

    @abstractmethod
    def _refusal(self, asked: Message) -> str:
        """Return why a goal can't be followed; nothing where it can."""

    @abstractmethod
    def _move(self, goal: _Goal) -> Operation[JointState]:
        """Begin to follow a goal."""

    @abstractmethod
    def _explain(self, result: Message, goal: _Goal, error: Exception | None) -> None:
        """Say in a result how a goal has ended."""

    @abstractmethod
    def _feedback(self, goal: _Goal, passed: float) -> Message:
        """Return feedback, some time after the motion began [s]; GripError where nothing is measured."""


class TrajectoryController(Controller):
    """A joint trajectory controller, with its topic `joint_trajectory` beside the action."""

    action_type, kind = ACTION, "joint_trajectory_controller/JointTrajectoryController"
    _executor: Executor

    def _make(self) -> ActionServer:
        def heard(trajectory: Message) -> None:
            asked = self._type.Goal(trajectory=trajectory)
            if self._takes(asked):
                self._take(asked)

        topic = f"{self.action.rpartition('/')[0]}/joint_trajectory"
        self._bus.node.create_subscription(load_type("trajectory_msgs/msg/JointTrajectory"), topic, heard, 10)
        return super()._make()

    def _refusal(self, asked: Message) -> str:
        points, names = asked.trajectory.points, list(asked.trajectory.joint_names)
        if sorted(names) != sorted(self.joints):
            return f"it moves {listing(names)}, not {listing(self.joints)}"
        times = [seconds(point.time_from_start) for point in points]
        if not times or times[0] < 0 or any(a >= b for a, b in pairwise(times)):
            return f"the times of its points must rise from 0 on, and are {times}"
        for row in (point.positions for point in points):
            if len(row) != len(names) or not np.isfinite(row).all():
                return f"each point needs a finite position of each of {len(names)} joints, and one has {list(row)}"
            if said := self._beyond(names, row):
                return said
        return ""

    def _move(self, goal: _Goal) -> Operation[JointState]:
        trajectory = goal.asked.trajectory
        names, state, streamed = list(trajectory.joint_names), self._executor.state(), goal.handle is None
        goal.path = continued(names, trajectory.points, state, streamed)
        return self._follow_path(goal.path)

    def _follow_path(self, path: Trajectory) -> Operation[JointState]:
        return self._executor.execute(path)

    def _explain(self, result: Message, goal: _Goal, error: Exception | None) -> None:
        if error is None:
            return
        result.error_string = str(error)
        replaced = isinstance(error, CanceledError)
        if not (replaced and goal.handle is not None and goal.handle.is_cancel_requested):
            result.error_code = result.INVALID_GOAL if replaced else result.PATH_TOLERANCE_VIOLATED

    def _feedback(self, goal: _Goal, passed: float) -> Message:
        now, path = self._executor.state(), goal.path
        feedback = self._type.Feedback(joint_names=list(path.names))
        feedback.header.stamp = self._bus.node.get_clock().now().to_msg()
        position, velocity, _ = path.sampled(np.array([passed]))
        measured = now.ordered(path.names)
        feedback.desired.positions, feedback.desired.velocities = position[0].tolist(), velocity[0].tolist()
        feedback.actual.positions, feedback.error.positions = measured.tolist(), (position[0] - measured).tolist()
        return feedback


SOON = 0.1
"""Least duration of a motion of fingers [s]."""


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

    def _refusal(self, asked: Message) -> str:
        command = asked.command
        fits = np.isfinite(command.position) and 0 <= command.max_effort < np.inf
        lacking = f"it needs a finite position and effort, not {command.position} and {command.max_effort}"
        return self._beyond(self.joints, [command.position]) if fits else lacking

    def _move(self, goal: _Goal) -> Operation[JointState]:
        command = goal.asked.command
        wanted = JointState(self.joints, np.array([command.position]))
        return self._executor.move(wanted, STROKE_TIME, force=command.max_effort or None)

    def _explain(self, result: Message, goal: _Goal, error: Exception | None) -> None:
        with suppress(GripError):
            self._measure(result, goal)

    def _feedback(self, goal: _Goal, passed: float) -> Message:
        feedback = self._type.Feedback()
        self._measure(feedback, goal)
        feedback.stalled = False  # it may still move
        return feedback

    def _measure(self, message: Message, goal: _Goal) -> None:
        state = self._executor.state()
        message.position = float(state.position[0])
        message.effort = 0.0 if state.effort is None else float(state.effort[0])
        message.reached_goal = abs(message.position - goal.asked.command.position) < CLOSE
        message.stalled = not message.reached_goal


class ControllerManager:
    """Serves `list_controllers` and `switch_controller` as ros2_control's manager does, for controllers by name."""

    services = ("/controller_manager/list_controllers", "/controller_manager/switch_controller")

    def __init__(self, bus: Bus, controllers: Sequence[Controller]):
        ensure_package("controller_manager_msgs")
        self._controllers = {each.name: each for each in controllers}
        self._state = load_type("controller_manager_msgs/msg/ControllerState")
        kinds = (load_type(f"controller_manager_msgs/srv/{name}") for name in ("ListControllers", "SwitchController"))

        def begin() -> None:
            for service, kind, answer in zip(self.services, kinds, (self._list, self._switch), strict=True):
                bus.node.create_service(kind, service, answer)

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
    """A goal that was accepted, and the motion that follows it; a cancel may come before that is begun.

    Attributes:
        handle: of the client that waits for its end; None where it came on the topic.
    """

    asked: Message
    handle: ServerGoalHandle | None
    future: Future
    turn: Operation[None]
    motion: Operation[JointState]
    path: Trajectory = field(init=False)

    def tell(self, feedback: Message) -> None:
        if self.handle is not None and self.handle.is_active:
            self.handle.publish_feedback(feedback)


def continued(names: Sequence[str], points: Sequence[Message], state: JointState, streamed: bool) -> Trajectory:
    """Return a trajectory through given points that begins where the joints are, as fast as they move.

    Args:
        points: of the message; times from now, the first may be later than 0. Velocities that aren't given are those of
            a curve through the points that rests at its end.
        streamed: whether others follow, so that joints go straight to a single point without velocities, and on.
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
    elif streamed and len(late) == 1:
        velocities = None
    else:
        velocities = np.gradient(positions, times, axis=0)
        velocities[0], velocities[-1] = now, 0.0
    return Trajectory(state.names, times, positions, velocities)
