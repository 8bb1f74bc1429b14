"""A joint trajectory controller by its topic: trajectories are published, and what becomes of them is measured.

The topic `~/joint_trajectory` of ros2_control's joint_trajectory_controller answers nothing: a trajectory that is
refused, or given up, is one that the joints don't follow.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

import numpy as np

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
BRAKE = 0.15
"""How long the joints take to come to rest on a stop [s]."""
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
    """

    def __init__(self, bus: Bus, topic: str, names: Sequence[str], states: JointStates):
        super().__init__(names, states)
        self._topic, self._writer = topic, bus.writer(MESSAGE, topic)

    def stop(self) -> None:
        """Have the joints come to rest on their path, and end a motion under way; nothing of it comes afterwards."""
        super().stop()
        if self._motion is not None:
            self._motion.wait(1.0)

    def _begin(self, trajectory: Trajectory) -> Operation[None]:
        stop = threading.Event()
        done: Operation[None] = Operation(on_cancel=stop.set)
        threading.Thread(target=self._follow, args=(trajectory, stop, done), name="grip_topic", daemon=True).start()
        return done

    def _follow(self, trajectory: Trajectory, stop: threading.Event, done: Operation[None]) -> None:
        try:
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
                self._hold(trajectory, time.monotonic() - began)
                done.fail(CanceledError("the motion was stopped"))
            else:
                self._judge(trajectory, done)
        except (ServerTimeOutError, SensorError) as error:
            done.fail(ExecutionAbortedError(error.message, cause=error.code))
        except BaseException as error:  # noqa: BLE001 - of this thread; the owner has to hear of it
            done.fail(error)

    def _hold(self, trajectory: Trajectory, passed: float) -> None:
        """Publish where the joints come to rest evenly: a bit further on their path, or where they are off that."""
        rest = trajectory.at(passed + BRAKE / 2)
        try:
            measured = self._states.state(trajectory.names).position
            if np.abs(measured - trajectory.at(passed)).max() > START_TOLERANCE:
                rest = measured
        except SensorError:
            pass  # to rest on the path is the best that is known then
        still = Trajectory(trajectory.names, np.zeros(1), rest[None], np.zeros((1, len(rest))))
        self._writer.publish(trajectory_to_message(still, BRAKE), 0)

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
