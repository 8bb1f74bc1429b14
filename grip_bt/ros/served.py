"""What we serve to others: measured joints and a camera on topics, an executor as a joint trajectory controller.

A goal begins when it is accepted, as ros2_control's joint_trajectory_controller does it, from where the joints are and
as fast as they move then, by a cubic spline through its points; one that comes while another is followed takes its
place, and the other is aborted. One that is cancelled ends as such when the joints have come to rest; until then its
owner hears, by feedback, where the joints should be and are.
"""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future

from grip_bt.base.errors import GripError
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Camera, Executor
from grip_bt.base.values import DepthImage, Image, JointState, Pose, RgbdFrame, Trajectory
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import Tree
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.convert_values import (
    camera_to_message,
    cloud_to_message,
    depth_to_message,
    header,
    image_to_message,
    pose_to_transform_stamped,
    seconds,
)
from grip_bt.ros.interfaces.build import ensure_package

from .client.types import Message, load_type
from .frames import FrameTree

TYPE = "sensor_msgs/msg/JointState"
RATE = 50.0
"""Messages of joint states a second."""


class Published:
    """What a thread of its own publishes until it is closed."""

    def __init__(self, name: str):
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._publish, name=name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Publish no more."""
        self._closed.set()
        self._thread.join(2.0)

    @abstractmethod
    def _publish(self) -> None:
        """Publish until it is closed."""


class JointStatePublisher(Published):
    """Publishes where joints are, in one message for all of them.

    Args:
        topic: such as `/joint_states`.
        now: the time of its stamps [s].
    """

    def __init__(self, bus: Bus, topic: str, executors: Sequence[Executor], now: Callable[[], float] = time.time):
        self._writer, self._executors, self._period, self._now = bus.writer(TYPE, topic), executors, 1 / RATE, now
        super().__init__("grip_joint_states")

    def _publish(self) -> None:
        due = time.monotonic()
        while not self._closed.wait(max(0.0, due - time.monotonic())):
            due = max(due + self._period, time.monotonic())
            try:
                self._writer.publish(self._message())
            except GripError:
                return  # what measures has ended; whoever runs it says so

    def _message(self) -> Message:
        stamp, states = self._now(), [executor.state() for executor in self._executors]
        message = self._writer.type(header=header("", stamp))
        message.name = [name for state in states for name in state.names]
        message.position = [float(value) for state in states for value in state.position]
        for part in ("velocity", "effort"):
            known = [getattr(state, part) for state in states]
            if all(values is not None for values in known):
                setattr(message, part, [float(value) for values in known for value in values])
        return message


TOPICS = {
    "image": ("color/image_raw", "sensor_msgs/msg/Image"),
    "depth": ("depth/image_raw", "sensor_msgs/msg/Image"),
    "info": ("color/camera_info", "sensor_msgs/msg/CameraInfo"),
    "points": ("points", "sensor_msgs/msg/PointCloud2"),
}

SHARE = 0.4
"""What takes the frames may spend no more than this share of its time on them: it moves the robot too."""


class CameraPublisher(Published):
    """Takes frames while somebody listens, and publishes them, all messages of a frame with one stamp.

    Everything is in the optical frame `<name>_optical`; where that is, is for TF or the listener's own settings.

    Args:
        name: its topics are `/<name>/color/image_raw` and so on.
        rate: frames a second, at most.
        now: the time of its stamps [s].
    """

    def __init__(self, bus: Bus, name: str, camera: Camera, rate: float = 5.0, now: Callable[[], float] = time.time):
        self._camera, self._period, self._now, self.frame = camera, 1 / rate, now, f"{name}_optical"
        self.topics = {part: f"/{name}/{topic}" for part, (topic, _) in TOPICS.items()}
        self._writers = {part: bus.writer(TOPICS[part][1], topic) for part, topic in self.topics.items()}
        for writer in self._writers.values():
            writer.advertise()
        super().__init__(f"grip_camera_{name}")

    def _publish(self) -> None:
        pause = 0.0
        while not self._closed.wait(pause):
            pause, began = self._period, time.monotonic()
            wanted = [part for part, writer in self._writers.items() if writer.listeners()]
            if not wanted:
                continue
            try:
                stamp = self._now()
                taken = self._camera.capture()
                taken.wait()
                self._send(taken.result(), stamp, wanted)
            except GripError:
                return  # the camera has ended; whoever runs it says so
            took = time.monotonic() - began
            pause = max(self._period - took, took / SHARE - took)

    def _send(self, taken: RgbdFrame, stamp: float, wanted: list[str]) -> None:
        info = replace(taken.depth.info, pose=Pose(frame=self.frame))
        here = RgbdFrame(Image(taken.image.pixels, self.frame, stamp), DepthImage(taken.depth.depth, info, stamp))
        messages = {
            "image": lambda: image_to_message(here.image),
            "depth": lambda: depth_to_message(here.depth),
            "info": lambda: camera_to_message(info),
            "points": lambda: cloud_to_message(here.cloud()),
        }
        for part in wanted:
            message = messages[part]()
            message.header.stamp.sec, message.header.stamp.nanosec = int(stamp), int(stamp % 1 * 1e9)
            message.header.frame_id = self.frame
            self._writers[part].publish(message)


ACTION = "control_msgs/action/FollowJointTrajectory"
AT_ONCE = 0.01
"""How long joints take that are to be elsewhere at once [s]."""
TELL = 0.05
"""How often feedback tells where the joints are [s]."""
NEAR = 1e-3
"""A first point that is due sooner is where the motion begins [s]."""


class TrajectoryActionServer:
    """Serves one action; made, used and closed from any thread.

    Args:
        action: such as `/arm_controller/follow_joint_trajectory`.
    """

    def __init__(self, bus: Bus, action: str, executor: Executor):
        ensure_package("control_msgs")
        self.action, self._bus, self._executor = action, bus, executor
        self._type = load_type(ACTION)
        self._lock = threading.Lock()
        self._newest: _Goal | None = None
        self._goals: dict[bytes, _Goal] = {}
        self._server = bus.ask(self._make)

    def close(self) -> None:
        """End a motion under way, and take no more goals."""
        self._executor.stop()
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
        points, names = goal.trajectory.points, list(goal.trajectory.joint_names)
        times = [seconds(p.time_from_start) for p in points]
        rising = all(a < b for a, b in zip(times, times[1:], strict=False))
        whole = all(len(p.positions) == len(names) and np.isfinite(p.positions).all() for p in points)
        fits = set(names) == set(self._executor.joint_names) and len(names) == len(set(names))
        return GoalResponse.ACCEPT if points and fits and rising and whole and times[0] >= 0 else GoalResponse.REJECT

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
        error = await self._goals[bytes(handle.goal_id.uuid)].future
        del self._goals[bytes(handle.goal_id.uuid)]
        result = self._type.Result()
        if error is None:
            handle.succeed()
            return result
        result.error_string = str(error)
        if isinstance(error, CanceledError) and handle.is_cancel_requested:
            handle.canceled()
            return result
        replaced = isinstance(error, CanceledError)
        result.error_code = result.INVALID_GOAL if replaced else result.PATH_TOLERANCE_VIOLATED
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
            self._tell(goal.handle, goal.path, time.monotonic() - began)

    def _begin(self, goal: _Goal) -> Operation[JointState]:
        if goal is not self._newest:  # threads come here in any order, and a later goal takes the place of this one
            raise CanceledError("a newer goal came")
        asked = goal.handle.request.trajectory
        goal.path = continued(list(asked.joint_names), asked.points, self._executor.state())
        return self._executor.execute(goal.path)

    def _tell(self, handle: ServerGoalHandle, path: Trajectory, passed: float) -> None:
        try:
            now = self._executor.state()
        except GripError:
            return  # the motion ends of the same
        feedback = self._type.Feedback(joint_names=list(path.names))
        feedback.header.stamp = self._bus.node.get_clock().now().to_msg()
        position, velocity, _ = path.sampled(np.array([passed]))
        measured = now.ordered(path.names)
        feedback.desired.positions, feedback.desired.velocities = position[0].tolist(), velocity[0].tolist()
        feedback.actual.positions, feedback.error.positions = measured.tolist(), (position[0] - measured).tolist()
        self._bus.post(lambda: handle.is_active and handle.publish_feedback(feedback))


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


KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For topics whose last message is for those, too, who come later."""


class RobotStatePublisher(Published):
    """Publishes `/robot_description`, `/tf` and `/tf_static`, as robot_state_publisher does.

    Args:
        executors: which measure all joints; others are where the description has them at rest.
        fixed: frames that don't move -> their pose in their parent, such as those of cameras.
        rate: of `/tf` [Hz].
        now: the time of its stamps [s].
    """

    def __init__(
        self,
        bus: Bus,
        description: RobotDescription,
        executors: Sequence[Executor],
        fixed: Mapping[str, Pose],
        rate: float = 30.0,
        now: Callable[[], float] = time.time,
    ):
        ensure_package("tf2_msgs")
        self._bus, self._executors, self._period, self._now = bus, executors, 1 / rate, now
        self._joints = [joint for joint in Tree.of(description.urdf).joints.values() if joint.movable]
        self._robot = description
        self._type, text = load_type("tf2_msgs/msg/TFMessage"), load_type("std_msgs/msg/String")
        frames = FrameTree.of_urdf(description.urdf).with_poses(fixed).poses
        node = bus.node

        def begin() -> None:
            self._moving = node.create_publisher(self._type, "/tf", 10)
            self._kept = [
                node.create_publisher(text, "/robot_description", KEPT),
                node.create_publisher(self._type, "/tf_static", KEPT),
            ]
            self._kept[0].publish(text(data=description.urdf))
            self._kept[1].publish(self._message(frames))

        bus.ask(begin)
        super().__init__("grip_robot_state")

    def _publish(self) -> None:
        while not self._closed.wait(self._period):
            try:
                positions = dict(self._robot.at_rest)
                for executor in self._executors:
                    positions |= executor.state().as_mapping()
            except GripError:
                return  # what measures has ended; whoever runs it says so
            there = self._robot.with_followers(positions)
            poses = {joint.child: joint.pose(there.get(joint.name, 0.0)) for joint in self._joints}
            message = self._message(poses)
            self._bus.post(partial(self._moving.publish, message))

    def _message(self, poses: Mapping[str, Pose]) -> Message:
        transforms, stamp = [], header("", self._now()).stamp
        for child, pose in poses.items():
            transform = pose_to_transform_stamped(pose)
            transform.child_frame_id, transform.header.stamp = child, stamp
            transforms.append(transform)
        return self._type(transforms=transforms)


class ClockPublisher(Published):
    """Publishes `/clock`.

    Args:
        now: the simulated time [s].
        rate: [Hz].
    """

    def __init__(self, bus: Bus, now: Callable[[], float], rate: float = 100.0):
        self._writer, self._now, self._period = bus.writer("rosgraph_msgs/msg/Clock", "/clock"), now, 1 / rate
        super().__init__("grip_clock")

    def _publish(self) -> None:
        while not self._closed.wait(self._period):
            self._writer.publish(self._writer.type(clock=header("", self._now()).stamp))
