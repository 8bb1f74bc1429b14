"""What the executors over ROS have in common: one motion at a time, begun where the joints are, ended as measured."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.failures import CanceledError, ExecutionAbortedError, ExpectedError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Steps, run_steps
from grip_bt.base.values import JointState, Trajectory
from grip_bt.commanders.trajectory.limits import RestDetector

from ..client.bus import Bus
from ..client.types import load_type
from ..interfaces.build import ensure_package
from .joint_states import JointStates

T = TypeVar("T")
START_TOLERANCE = 0.05
"""A trajectory begins within this distance of where the joints are [rad or m]."""

REACHED = 1e-3
"""Joints this near to the last set-point have reached it [rad or m]."""
STILL = 0.3
"""Joints that were measured at one place for this time don't come nearer to it [s]."""
MOVED = 1e-4
"""A joint that moved less between two measurements stood still [rad or m]."""
SETTLE = 3.0
"""How long joints may take in all to catch up with the last set-point [s]."""
LOOK = 0.01
"""How often that is looked at [s]."""


class MovedJoints:
    """Joints of which one motion at a time is under way.

    Args:
        names: the joints, in their order.
    """

    def __init__(self, names: Sequence[str], states: JointStates):
        self.joint_names, self._states = tuple(names), states
        self._motion: Motion | None = None

    def state(self) -> JointState:
        """Return the measured state of the joints. Raises SensorError: nothing is known of one of them."""
        return self._states.state(self.joint_names)

    def stop(self) -> None:
        """Bring the joints to rest; a motion under way ends as cancelled when they are measured to be there."""
        if self._motion is not None:
            self._motion.whole.cancel()

    def _move(
        self, begin: Callable[[], Operation[T]], ended: Callable[[T], Operation[JointState]] | None = None
    ) -> Operation[JointState]:
        """Begin a motion in the place of the one under way; the result is what is measured when it has `ended`."""
        self.give_way()
        part = begin().then(ended or (lambda _: measured(self._states, self.joint_names)))
        self._motion = Motion(part, self._states, self.joint_names)
        return self._motion.whole

    def give_way(self) -> None:
        """End a motion under way for another one that takes its place."""
        if self._motion is not None:
            self._drop()
            self._motion.preempt()

    def _drop(self) -> None:
        """See to it that nothing more is sent of a motion whose place another one takes."""


class RosExecutor(MovedJoints, ABC):
    """Implements `grip_bt.base.ports.Executor` but for how a motion is begun."""

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        """Follow a trajectory; one under way ends as cancelled. The result is what is measured at the end.

        A motion that was cancelled, or given up, ends when the joints were measured at rest. Where they aren't within
        `rest.RESTS`, or nothing is measured, the error says so, and `stopped` in its data is False.

        Ends with ExecutionAbortedError when the trajectory begins elsewhere, or who moves the joints refuses it, gives
        it up or is gone; `data` tells the code and the words. See `grip_bt.base.ports.Executor`.

        Raises:
            ValueError: it moves other joints.
        """
        if set(trajectory.names) != set(self.joint_names):
            raise ValueError(f"the trajectory moves {trajectory.names}, this executor {self.joint_names}")
        try:
            off = np.abs(trajectory.positions[0] - self._states.state(trajectory.names).position)
        except SensorError as error:
            return Operation.failed(ExecutionAbortedError(error.message, cause=error.code))
        if off.max() > START_TOLERANCE:
            joint, far = trajectory.names[int(off.argmax())], float(off.max())
            reason = f"the trajectory starts {far:.3f} from the measured position of joint {joint}"
            return Operation.failed(ExecutionAbortedError(reason, error=far))
        return self._move(lambda: self._begin(trajectory))

    @abstractmethod
    def _begin(self, trajectory: Trajectory) -> Operation[Any]:
        """Begin a motion of our joints from where they are; the operation ends when it does, or says why it can't."""


class ActionExecutor(RosExecutor):
    """An executor over an action; `wait`: how long to wait for its server to appear [s]."""

    interface: str

    def __init__(self, bus: Bus, action: str, names: Sequence[str], states: JointStates, wait: float = 5.0):
        super().__init__(names, states)
        ensure_package(self.interface.partition("/")[0])
        self._type = load_type(self.interface)
        self._client, self._action, self._wait = bus.action(self._type, action), action, wait


def measured(states: JointStates, names: Sequence[str]) -> Operation[JointState]:
    """Return what is measured from now on; ends with ExecutionAbortedError when nothing is."""

    def steps() -> Steps[JointState]:
        try:
            state: JointState = yield states.fresh(names)
            return state
        except SensorError as error:
            raise ExecutionAbortedError(f"the motion ended, but {error.message}", cause=error.code) from None

    return run_steps(steps())


def settle(state: Callable[[], JointState], target: NDArray[np.float64], stop: threading.Event) -> None:
    """Block until joints are at `target`, or stand still elsewhere by the stamps of what is measured; or on `stop`."""
    deadline = time.monotonic() + SETTLE
    moved: JointState | None = None
    while time.monotonic() < deadline and not stop.wait(LOOK):
        try:
            now = state()
        except SensorError:
            return  # the measurement at the end says so
        if np.abs(now.position - target).max() <= REACHED:
            return
        if moved is None or np.abs(now.position - moved.position).max() > MOVED:
            moved = now
        elif now.time - moved.time > STILL:
            return


RESTS = 3.0
"""How long joints may take until they are measured at rest [s]."""


def rest_of_joints(states: JointStates, names: tuple[str, ...], within: float = RESTS) -> Operation[str]:
    """Return an operation that ends when joints are measured at rest; its result is empty then.

    Where they aren't `within` [s], the result says what is known instead.
    """
    judge = RestDetector()

    def why() -> str:
        return f"{judge.moving} still moves" if judge.moving else "nothing was measured of the joints since"

    return states.watch(names, judge.see, within).then(
        lambda at_rest: Operation.finished("" if at_rest else f"after {within:g} s {why()}")
    )


class Motion:
    """A motion under way, which ends only with the joints at rest; see `whole`.

    Attributes:
        whole: ends as `part` does; with an error only when the joints were measured at rest, or that can't be
            confirmed, which the error then says (`stopped` in its data is False).

    Args:
        part: what moves the joints; its result is the motion's.
    """

    def __init__(self, part: Operation[JointState], states: JointStates, names: tuple[str, ...]):
        self._part, self._states, self.joint_names = part, states, names
        self._preempted = False
        self.whole: Operation[JointState] = Operation(on_cancel=part.cancel)
        part.add_done_callback(self._ended)

    def preempt(self) -> None:
        """End it for another motion that takes its place, and don't wait for joints that go on by that."""
        self._preempted = True
        self.whole.cancel()
        if self._part.done():
            self.whole.fail(CanceledError("preempted by another motion"))

    def _ended(self) -> None:
        try:
            self.whole.succeed(self._part.result())
        except (CanceledError, ExecutionAbortedError) as error:
            self._wait_for_rest(error)
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            self.whole.fail(error)

    def _wait_for_rest(self, error: ExpectedError) -> None:
        if self._preempted:
            self.whole.fail(CanceledError("preempted by another motion"))
            return
        rest = rest_of_joints(self._states, self.joint_names)

        def end() -> None:
            moving = rest.result()
            if moving:
                said = f"{error.message}; could not confirm that the joints have stopped: {moving}"
                self.whole.fail(type(error)(said, **{**error.data, "stopped": False}))
            else:
                self.whole.fail(error)

        rest.add_done_callback(end)
