"""The simulator behind GRIP's ports: joints, hand, camera, and the referee, who isn't a port."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, DepthImage, Image, JointState, Pose, RgbdFrame, Trajectory
from grip_sim.client import SimClient
from grip_sim.connection import Reply
from grip_sim.referee import ObjectTruth


def _state(reply: Reply) -> JointState:
    arrays = reply.arrays
    names = tuple(reply.fields["names"])
    return JointState(names, arrays["position"], arrays["velocity"], arrays["effort"], reply.time)


def _measured(operation: Operation[Reply]) -> Operation[JointState]:
    return operation.then(lambda reply: Operation.finished(_state(reply)))


class _Joints:
    """What a group of simulated joints has in common."""

    def __init__(self, client: SimClient, names: tuple[str, ...]):
        self._client, self._names = client, names

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints, in order."""
        return self._names

    def state(self) -> JointState:
        """Return the measured state; efforts are the drives' torques [N m]."""
        return _state(self._client.ask("state", names=list(self._names)))

    def stop(self) -> None:
        """Hold where the joints are and end a motion under way; what stands still keeps pressing as it did."""
        self._client.ask("stop", names=list(self._names))


class SimExecutor(_Joints):
    """Implements `grip_bt.base.ports.Executor` and `grip_bt.base.ports.Steerable`."""

    steerable = True

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        """Follow a trajectory; see the port.

        Raises:
            ValueError: the trajectory isn't for these joints, or holds what isn't a number.
        """
        return _measured(self._client.move("follow", self._arrays(trajectory), names=list(self._names)))

    def passed(self) -> float | None:
        """Return for how long the motion under way has been followed, in simulated time [s]; see `ports.Steerable`."""
        return self._client.ask("passed", names=list(self._names)).fields["passed"]

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with another trajectory from a moment on; see `ports.Steerable`."""
        arrays = self._arrays(tail)
        if "velocities" not in arrays:
            arrays["velocities"] = np.gradient(arrays["positions"], tail.times, axis=0)
        return bool(self._client.ask("amend", arrays, names=list(self._names), at=at).fields["amended"])

    def _arrays(self, trajectory: Trajectory) -> dict[str, Array]:
        if set(trajectory.names) != set(self._names):
            raise ValueError(f"the trajectory is for {trajectory.names}, not for {self._names}")
        _check_finite("a trajectory", trajectory.times, trajectory.positions, trajectory.velocities)
        order = [trajectory.names.index(name) for name in self._names]
        arrays = {"times": trajectory.times, "positions": trajectory.positions[:, order]}
        if trajectory.velocities is not None:
            arrays["velocities"] = trajectory.velocities[:, order]
        return arrays


class SimHand(_Joints):
    """Implements `grip_bt.base.ports.HandPort`."""

    def move(self, posture: JointState, duration: float, torque_limit: float | None = None) -> Operation[JointState]:
        """Move the fingers towards a posture; see the port.

        Raises:
            KeyError: the posture lacks a joint.
            ValueError: the posture isn't finite, or the duration or the limit isn't positive.
        """
        goal = posture.ordered(self._names)
        _check_finite("a posture", goal)
        check_positive("the duration of a motion", duration)
        if torque_limit is not None:
            check_positive("a torque limit", torque_limit)
        moved = self._client.move(
            "move_hand", {"goal": goal}, names=list(self._names), duration=duration, limit=torque_limit
        )
        return _measured(moved)

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link of the hand that touches something that isn't the robot."""
        return self._client.ask("contacts").fields["contacts"]


class SimCamera:
    """Implements `grip_bt.base.ports.Camera`."""

    def __init__(self, client: SimClient, name: str, info: CameraInfo):
        self._client, self._name, self._info = client, name, info

    def info(self) -> CameraInfo:
        """Return the camera's geometry."""
        return self._info

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame."""
        return self._client.request("look", camera=self._name).then(self._frame)

    def _frame(self, reply: Reply) -> Operation[RgbdFrame]:
        time = reply.time
        image = Image(reply.arrays["image"], f"{self._name}_optical", time)
        return Operation.finished(RgbdFrame(image, DepthImage(reply.arrays["depth"], self._info, time)))


class SimReferee:
    """What is true, whatever a task believes. Never given to a task."""

    def __init__(self, client: SimClient):
        self._client = client

    def truth(self) -> dict[str, ObjectTruth]:
        """Return the truth about each object, as it is now."""
        verdicts = [ObjectTruth.from_json(data) for data in self._client.ask("truth").fields["truth"]]
        return {verdict.name: verdict for verdict in verdicts}

    def fingerprint(self) -> str:
        """Return a hash over the state of everything that moves."""
        return str(self._client.ask("fingerprint").fields["fingerprint"])

    def move_object(self, name: str, pose: Pose) -> None:
        """Put an object elsewhere, to disturb a task."""
        place: dict[str, Any] = {"position": pose.position.tolist(), "quaternion": pose.quaternion.tolist()}
        self._client.ask("move_object", name=name, **place)


def check_positive(what: str, number: float) -> None:
    """Raise ValueError unless a number is finite and positive."""
    if not 0 < number < np.inf:
        raise ValueError(f"{what} must be a positive number, not {number}")


def _check_finite(what: str, *arrays: Array | None) -> None:
    if not all(np.isfinite(array).all() for array in arrays if array is not None):
        raise ValueError(f"{what} must consist of finite numbers; it holds NaN or infinity")


__all__ = ["SimCamera", "SimExecutor", "SimHand", "SimReferee"]
