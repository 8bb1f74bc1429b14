"""Executors over a topic, where nobody answers: a thread follows each motion to its end and measures what comes of it.

A controller is streamed samples of the trajectory, and of braking: a position controller as numbers, a joint trajectory
controller (`~/joint_trajectory` of ros2_control) as trajectories of one point, as MoveIt Servo does it. What it refuses
the joints don't follow.
"""

from __future__ import annotations

import threading
import time
from array import array
from collections.abc import Mapping, Sequence

import numpy as np

from grip_bt.base.failures import CanceledError, ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory
from grip_bt.commanders.steering import spliced
from grip_bt.commanders.trajectory.stopping import accelerations_of, jerks_of, stop_ramp

from ..client.bus import Bus
from ..client.types import Message, load_type
from ..convert_values import trajectory_to_message
from .joint_states import JointStates
from .motion import START_TOLERANCE, RosExecutor, settle

PERIOD = 0.01
"""How often a set-point is sent [s]."""
BEHIND = 0.5
"""How far joints, or what is heard of them, may be behind the set-points [s] and still count as on their way."""
END_TOLERANCE = 0.05
"""A motion has succeeded when the joints come to rest this near to its end [rad or m]."""


class StreamedMotion:
    """A motion under way, whose trajectory may be changed while its set-points are sent.

    Attributes:
        stop: set when it is to come to rest.
        dropped: set, with `stop`, when nothing more is to be sent, since another motion takes its place.
        over: whether nothing of it can be changed any more.
        sent: the time of the last set-point [s].
    """

    def __init__(self, trajectory: Trajectory):
        self.trajectory = trajectory
        self.stop, self.dropped, self._left = threading.Event(), threading.Event(), threading.Event()
        self._lock = threading.Lock()
        self._began: float | None = None
        self.over, self.sent = False, 0.0

    def drop(self) -> None:
        """Have nothing more sent, and wait until that is so."""
        self.dropped.set()
        self.stop.set()
        self._left.wait(1.0)

    def leave(self) -> None:
        self.over = True
        self._left.set()

    def begin(self) -> None:
        self._began = time.monotonic()

    def passed(self) -> float:
        return 0.0 if self._began is None else time.monotonic() - self._began

    def at(self, time: float) -> np.ndarray:
        with self._lock:
            return self.trajectory.at(time)

    def ended(self) -> bool:
        """Tell whether all of it is sent; it can't be changed any more then."""
        with self._lock:
            self.over = self.over or self.passed() >= self.trajectory.duration
            return self.over

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; False where that has passed."""
        with self._lock:
            whole = spliced(self.trajectory, tail, at)
            if self.over or self.passed() > min(at, self.trajectory.duration):
                return False
            self.trajectory = whole
            return True


class StreamedExecutor(RosExecutor):
    """Implements `grip_bt.base.ports.Executor` and `Steerable` over a joint group position controller.

    Args:
        accelerations: joint -> limit, for braking; see `trajectory.braking.accelerations_of`.
        jerks: joint -> limit, for braking; any where it names none.
    """

    steerable = True
    message = "std_msgs/msg/Float64MultiArray"
    """The topic's interface."""
    ahead = PERIOD
    """How long after a set-point was sent the joints are to be there [s]."""
    judges = False
    """Whether a motion is aborted when the robot is gone, or joints come to rest elsewhere than at its end."""

    def __init__(
        self,
        bus: Bus,
        topic: str,
        names: Sequence[str],
        states: JointStates,
        accelerations: Mapping[str, float] | None = None,
        jerks: Mapping[str, float] | None = None,
    ):
        super().__init__(names, states)
        self._accelerations, self._jerks = accelerations or {}, jerks or {}
        self._topic, self._writer = topic, bus.writer(self.message, topic)
        self._current: StreamedMotion | None = None

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed [s]; see `ports.Steerable`."""
        way = self._current
        return None if way is None or way.over else way.passed()

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        way = self._current
        return way is not None and way.amend(tail.of(self.joint_names), at)

    def execute_steered(self, trajectory: Trajectory) -> Operation[JointState]:
        return self.execute(trajectory)

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        self._current = way = StreamedMotion(trajectory.of(self.joint_names))
        done: Operation[None] = Operation(on_cancel=way.stop.set)
        threading.Thread(target=self._run, args=(way, done), name="grip_topic_motion", daemon=True).start()
        return done

    def _drop(self) -> None:
        if self._current is not None:
            self._current.drop()

    def _run(self, way: StreamedMotion, done: Operation[None]) -> None:
        try:
            self._follow(way)
            if way.stop.is_set():
                done.fail(CanceledError("the motion was stopped"))
            else:
                done.succeed(None)
        except (ServerTimeOutError, SensorError) as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)
        finally:
            way.leave()

    def _follow(self, way: StreamedMotion) -> None:
        """Publish set-points in time; on a stop, those of a ramp.

        Raises:
            ServerTimeOutError: nobody listens.
            SensorError: the robot is gone.
            ExecutionAbortedError: the joints don't do it.
        """
        first = self._publish(way.trajectory.positions[0], 1)
        if not first.wait(6.0):
            raise ServerTimeOutError(f"{self._topic}: there are no subscribers")
        first.result()
        way.begin()
        while not way.ended():
            if way.stop.wait(PERIOD):
                break
            way.sent = way.passed() + self.ahead
            self._publish(way.at(way.sent), 0)
            if self.judges:
                self.state()
        else:
            last, way.sent = way.trajectory.positions[-1], way.trajectory.duration
            self._publish(last, 0).wait(1.0)
            settle(self.state, last, way.stop)
        way.over = True
        if way.stop.is_set():
            self._brake(way)
        elif self.judges:
            self._judge(way.trajectory)

    def _brake(self, way: StreamedMotion) -> None:
        """Stream the ramp from the last set-point on; where something keeps the joints off their way, they stay there.

        A measurement is late. Joints that follow were there a moment ago, and holding there would send them back.
        """
        held = self._held_back(way)
        if held is not None and not way.dropped.is_set():
            self._publish(held, 0)
            return
        names = way.trajectory.names
        limits, jerks = accelerations_of(names, self._accelerations), jerks_of(names, self._jerks)
        ramp = stop_ramp(way.trajectory, way.sent, limits, jerks)
        began, passed = time.monotonic(), 0.0
        while passed < ramp.duration and not way.dropped.wait(PERIOD):
            passed = time.monotonic() - began
            self._publish(ramp.at(passed), 0)
        settle(self.state, ramp.positions[-1], way.dropped)  # set-points may still be on their way

    def _held_back(self, way: StreamedMotion) -> np.ndarray | None:
        """Return where joints are that aren't on their way, nor a bit behind on it; else None."""
        try:
            measured = self._states.state(way.trajectory.names).position
        except SensorError:
            return None  # to come to rest on the way is the best that is known then
        lately = np.stack([way.at(t) for t in np.linspace(max(0.0, way.sent - BEHIND), way.sent, 51)])
        off = np.abs(lately - measured).max(axis=1).min()
        return measured if off > START_TOLERANCE else None

    def _publish(self, positions: np.ndarray, subscribers: int) -> Operation[None]:
        return self._writer.publish(self._set_point(positions), subscribers)

    def _set_point(self, positions: np.ndarray) -> Message:
        return load_type(self.message)(data=array("d", positions))

    def _judge(self, trajectory: Trajectory) -> None:
        off = np.abs(self._states.state(trajectory.names).position - trajectory.positions[-1])
        worst = int(off.argmax())
        if off[worst] <= END_TOLERANCE:
            return
        joint = trajectory.names[worst]
        reason = f"{self._topic}: joint {joint} stands {off[worst]:.3f} short of the end of the motion"
        hint = "see the controller's log: it may have rejected the set-points, be inactive, or be blocked"
        raise ExecutionAbortedError(f"{reason}; {hint}", stopped_short=float(off[worst]))


class TopicExecutor(StreamedExecutor):
    """Implements `grip_bt.base.ports.Executor` and `Steerable` over the topic of a joint trajectory controller.

    A motion ends when the joints are measured to be at its end, or to stand still. Where that is elsewhere, it is
    aborted, and `data` has `stopped_short`: how far off.
    """

    message = "trajectory_msgs/msg/JointTrajectory"
    judges = True
    ahead = 0.03  # the controller interpolates, so that a set-point which comes a bit late lets no joint stand still

    def _set_point(self, positions: np.ndarray) -> Message:
        return trajectory_to_message(Trajectory(self.joint_names, np.zeros(1), positions[None]), self.ahead)
