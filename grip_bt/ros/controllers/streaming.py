"""Executors over a topic, where nobody answers: a thread follows each motion to its end and measures what comes of it.

A position controller is streamed samples of the trajectory, and of braking. A joint trajectory controller
(`~/joint_trajectory` of ros2_control) is sent it whole; one that it refuses, or gives up, the joints don't follow.
"""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from array import array
from collections.abc import Mapping, Sequence
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.failures import CanceledError, ExecutionAbortedError, SensorError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Trajectory
from grip_bt.commanders.steering import spliced
from grip_bt.commanders.trajectory.stopping import accelerations_of, jerks_of, stop_ramp

from ..client.bus import Bus
from ..client.types import load_type
from ..convert_values import trajectory_to_message
from .joint_states import JointStates
from .motion import START_TOLERANCE, RosExecutor, settle

PERIOD = 0.01
"""How often a set-point is sent [s]."""
BEHIND = 0.5
"""How far joints, or what is heard of them, may be behind the set-points [s] and still count as on their way."""


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
        """Say that nothing more is sent."""
        self.over = True
        self._left.set()

    def begin(self) -> None:
        """Count the time from now on."""
        self._began = time.monotonic()

    def passed(self) -> float:
        """Return for how long it has been streamed [s]."""
        return 0.0 if self._began is None else time.monotonic() - self._began

    def at(self, time: float) -> np.ndarray:
        """Return the positions at a time [s], shape (n,)."""
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


class TopicMotionExecutor(RosExecutor):
    """An executor over a topic, but for how a motion is seen to.

    Args:
        accelerations: joint -> limit, for braking; see `trajectory.braking.accelerations_of`.
        jerks: joint -> limit, for braking with set-points; any where it names none.
    """

    message: str
    """The topic's interface."""

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
        self._topic, self._writer, self._watchdog = topic, bus.writer(self.message, topic), bus.watchdog
        self._current: StreamedMotion | None = None

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        self._current = way = StreamedMotion(trajectory)
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

    def _order(self, trajectory: Trajectory) -> list[int]:
        return [trajectory.names.index(name) for name in self._names]

    def _limits(self, trajectory: Trajectory) -> NDArray[np.float64]:
        return accelerations_of(trajectory.names, self._accelerations)

    @abstractmethod
    def _follow(self, way: StreamedMotion) -> None:
        """Follow a motion until it has ended, or, on a stop, has braked.

        Raises:
            ServerTimeOutError: nobody listens.
            SensorError: nothing is measured of the joints any more.
            ExecutionAbortedError: the joints don't do it.
        """


class StreamedExecutor(TopicMotionExecutor):
    """Implements `grip_bt.base.ports.Executor` and `Steerable` over a joint group position controller."""

    steerable = True

    message = "std_msgs/msg/Float64MultiArray"

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed [s]; see `ports.Steerable`."""
        way = self._current
        return None if way is None or way.over else way.passed()

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        way = self._current
        return way is not None and way.amend(tail, at)

    def _follow(self, way: StreamedMotion) -> None:
        """Publish set-points in time; on a stop, those of a ramp."""
        order = self._order(way.trajectory)
        first = self._publish(way.trajectory.positions[0][order], 1)
        if not first.wait(6.0):
            raise ServerTimeOutError(f"{self._topic}: there are no subscribers")
        first.result()
        way.begin()
        while not way.ended():
            if way.stop.wait(PERIOD):
                break
            way.sent = way.passed() + PERIOD
            self._publish(way.at(way.sent)[order].tolist(), 0)
        else:
            last, way.sent = way.trajectory.positions[-1][order], way.trajectory.duration
            self._publish(last.tolist(), 0).wait(1.0)
            settle(self.state, last, way.stop)
        way.over = True
        if way.stop.is_set():
            self._brake(way, order)

    def _brake(self, way: StreamedMotion, order: list[int]) -> None:
        """Stream the ramp from the last set-point on; where something keeps the joints off their way, they stay there.

        A measurement is late. Joints that follow were there a moment ago, and holding there would send them back.
        """
        held = self._held_back(way)
        if held is not None and not way.dropped.is_set():
            self._publish(held[order].tolist(), 0)
            return
        jerks = jerks_of(way.trajectory.names, self._jerks)
        ramp = stop_ramp(way.trajectory, way.sent, self._limits(way.trajectory), jerks)
        began, passed = time.monotonic(), 0.0
        while passed < ramp.duration and not way.dropped.wait(PERIOD):
            passed = time.monotonic() - began
            self._publish(ramp.at(passed)[order].tolist(), 0)
        settle(self.state, ramp.positions[-1][order], way.dropped)  # set-points may still be on their way

    def _held_back(self, way: StreamedMotion) -> np.ndarray | None:
        """Return where joints are that aren't on their way, nor a bit behind on it, in the way's order; else None."""
        try:
            measured = self._states.state(way.trajectory.names).position
        except SensorError:
            return None  # to come to rest on the way is the best that is known then
        lately = np.stack([way.at(t) for t in np.linspace(max(0.0, way.sent - BEHIND), way.sent, 51)])
        off = np.abs(lately - measured).max(axis=1).min()
        return measured if off > START_TOLERANCE else None

    def _publish(self, positions: Sequence[float], subscribers: int) -> Operation[None]:
        return self._writer.publish(load_type(self.message)(data=array("d", positions)), subscribers)


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


class TopicExecutor(TopicMotionExecutor):
    """Implements `grip_bt.base.ports.Executor` over the topic of a joint trajectory controller.

    A motion ends when the joints are measured to be at its end, or to stand still. Where that is elsewhere, it is
    aborted, and `data` has `stopped_short`: how far off.
    """

    message = "trajectory_msgs/msg/JointTrajectory"

    def _follow(self, way: StreamedMotion) -> None:
        trajectory, stop = way.trajectory, way.stop
        with ExitStack() as stack:
            if self._watchdog is not None:
                self._watchdog.trajectory_sent(self._topic, self._names)
                stack.callback(self._watchdog.trajectory_ended, self._topic)
            sent = self._writer.publish(trajectory_to_message(trajectory), 1, FOUND)
            if not sent.wait(FOUND + 1.0):
                raise ServerTimeOutError(f"{self._topic}: there are no subscribers")
            sent.result()
            began = time.monotonic()
            while not stop.is_set() and (left := began + trajectory.duration - time.monotonic()) > 0:
                stop.wait(min(left, LOOK))
                self.state()  # a robot that is gone ends the motion
            if not stop.is_set():
                settle(self.state, trajectory.positions[-1][self._order(trajectory)], stop)
            if not stop.is_set():
                self._judge(trajectory)
            elif not way.dropped.is_set():
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
        off = np.abs(self._states.state(trajectory.names).position - trajectory.positions[-1])
        worst = int(off.argmax())
        if off[worst] <= END_TOLERANCE:
            return
        joint = trajectory.names[worst]
        reason = f"{self._topic}: joint {joint} stands {off[worst]:.3f} short of the end of the motion"
        hint = "see the controller's log: it may have rejected or aborted the trajectory, be inactive, or be blocked"
        raise ExecutionAbortedError(f"{reason}; {hint}", stopped_short=float(off[worst]))
