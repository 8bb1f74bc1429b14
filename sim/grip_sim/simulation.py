"""A simulation to work with: the process, its parts behind GRIP's ports, the referee, and its certain end."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, DepthImage, Image, JointState, Pose, RgbdFrame, Trajectory
from grip_bt.base.values.joints import ContactPoint
from grip_bt.commanders.description.load import load_robot
from grip_sim.client import SimClient
from grip_sim.connection import Reply
from grip_sim.faults import Fault
from grip_sim.referee import ObjectTruth
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec

_log = logging.getLogger(__name__)


def _state(reply: Reply) -> JointState:
    said = reply.fields
    return JointState(tuple(said["names"]), said["position"], said["velocity"], said["effort"], reply.time)


def _measured(operation: Operation[Reply]) -> Operation[JointState]:
    return operation.then(lambda reply: Operation.finished(_state(reply)))


class _Joints:
    def __init__(self, client: SimClient, names: tuple[str, ...]):
        self._client, self.joint_names = client, names

    def state(self) -> JointState:
        return _state(self._client.ask("state", names=list(self.joint_names)))

    def stop(self) -> None:
        self._client.ask("stop", names=list(self.joint_names))


class SimExecutor(_Joints):
    """Implements `grip_bt.base.ports.Executor` and `grip_bt.base.ports.Steerable`.

    Attributes:
        from_here: whether a motion begins where the joints are then and as fast, whatever its first point is.
    """

    steerable, from_here = True, False

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        """See the port. Raises ValueError where it isn't for these joints, or holds what isn't a number."""
        said = {"names": list(self.joint_names), "from_here": self.from_here, **self._arrays(trajectory)}
        return _measured(self._client.move("follow", **said))

    execute_steered = execute

    def passed(self) -> float | None:
        return self._client.ask("passed", names=list(self.joint_names)).fields["passed"]

    def amend(self, tail: Trajectory, at: float) -> bool:
        arrays = self._arrays(tail)
        if "velocities" not in arrays:
            arrays["velocities"] = np.gradient(arrays["positions"], tail.times, axis=0)
        return bool(self._client.ask("amend", names=list(self.joint_names), at=at, **arrays).fields["amended"])

    def _arrays(self, trajectory: Trajectory) -> dict[str, Array]:
        if set(trajectory.names) != set(self.joint_names):
            raise ValueError(f"the trajectory is for {trajectory.names}, not for {self.joint_names}")
        _check_finite("a trajectory", trajectory.times, trajectory.positions, trajectory.velocities)
        way = trajectory.of(self.joint_names)
        arrays = {"times": way.times, "positions": way.positions, "velocities": way.velocities}
        return {name: each for name, each in arrays.items() if each is not None}


class SimHand(_Joints):
    """Implements `grip_bt.base.ports.HandPort` and `Touch`."""

    def move(
        self, posture: JointState, duration: float, torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        """See the port. Raises KeyError for a missing joint, ValueError where a number isn't finite or positive."""
        goal = posture.ordered(self.joint_names)
        _check_finite("a posture", goal)
        check_positive("the duration of a motion", duration)
        check_positive("a torque limit", 1.0 if torque_limit is None else torque_limit)
        check_positive("a force", 1.0 if force is None else force)
        said = {"names": list(self.joint_names), "duration": duration, "limit": torque_limit, "force": force}
        return _measured(self._client.move("move_hand", goal=goal, **said))

    def _felt(self, what: str) -> Any:
        return self._client.ask("feel", names=list(self.joint_names), what=what).fields["felt"]

    def contacts(self) -> Mapping[str, float]:
        return self._felt("hand_contacts")

    def contact_points(self) -> list[ContactPoint]:
        return [ContactPoint(link, other, tuple(at), tuple(f)) for link, other, at, f in self._felt("contact_points")]

    def slips(self) -> Mapping[str, float]:
        return self._felt("slips")

    def link_wrenches(self) -> Mapping[str, Array]:
        """Return each link's force [N] and torque [N m] from what isn't the robot, in its frame, shape (6,)."""
        return self._felt("link_wrenches")

    def wrench(self) -> Mapping[str, Array]:
        """Return the wrist's link, and the force [N] and torque [N m] that it bears, in its frame, shape (6,)."""
        return self._felt("wrench")


class SimCamera:
    """Implements `grip_bt.base.ports.Camera`; one on a link is where the link is."""

    def __init__(self, client: SimClient, spec: CameraSpec):
        self._client, self._name, self._info = client, spec.name, spec.info()

    def info(self) -> CameraInfo:
        return replace(self._info, pose=_pose(self._client.ask("camera_pose", camera=self._name)))

    def capture(self) -> Operation[RgbdFrame]:
        return self._client.request("look", camera=self._name).then(self._frame)

    def _frame(self, reply: Reply) -> Operation[RgbdFrame]:
        time, info = reply.time - reply.fields["age"], replace(self._info, pose=_pose(reply))
        image = Image(reply.fields["image"], f"{self._name}_optical", time)
        return Operation.finished(RgbdFrame(image, DepthImage(reply.fields["depth"], info, time)))


def _pose(reply: Reply) -> Pose:
    rows = reply.fields["pose"]
    return Pose(rows[:3], rows[3:])


class SimReferee:
    """What is true, whatever a task believes. Never given to a task."""

    def __init__(self, client: SimClient):
        self._client = client

    def truth(self) -> dict[str, ObjectTruth]:
        """Return the truth about each object, as it is now."""
        verdicts = [ObjectTruth(*said) for said in self._client.ask("truth").fields["truth"]]
        return {verdict.name: verdict for verdict in verdicts}

    def measures(self) -> dict[str, float]:
        """Return the numbers that it has of articulated objects, such as `cabinet_opened` [m]."""
        return dict(self._client.ask("measures").fields["measures"])

    def fingerprint(self) -> str:
        """Return a hash over the state of everything that moves."""
        return str(self._client.ask("fingerprint").fields["fingerprint"])

    def move_object(self, name: str, pose: Pose) -> None:
        """Put an object elsewhere, to disturb a task."""
        place = {"position": pose.position.tolist(), "quaternion": pose.quaternion.tolist()}
        self._client.ask("move_object", name=name, **place)


def check_positive(what: str, number: float) -> None:
    """Raise ValueError unless a number is finite and positive."""
    if not 0 < number < np.inf:
        raise ValueError(f"{what} must be a positive number, not {number}")


def _check_finite(what: str, *arrays: Array | None) -> None:
    if not all(np.isfinite(array).all() for array in arrays if array is not None):
        raise ValueError(f"{what} must consist of finite numbers; it holds NaN or infinity")


class Simulation(SimClient):
    """A running simulator, whose physics advances only while something is under way; implements `ports.Stepped`."""

    def __init__(self, spec: WorldSpec, pace: float | None = None, hold: int | None = None):
        if pace is not None:
            check_positive("pace", pace)
        self._robot = load_robot(spec.robot)  # first: an unknown robot is found before a process runs
        super().__init__(spec, pace, hold)
        self.spec, self.referee = spec, SimReferee(self)

    def begin(self, spec: WorldSpec) -> None:
        """Have another world, whose objects come to rest, in this one's place; whatever ran in this one has to be over.

        Raises:
            SimulatorLostError, GripError, UnknownNameError: see `start_simulation`.
        """
        self._robot = load_robot(spec.robot)
        super().begin(spec)
        self.spec = spec
        self.settle()

    def executor(self, group: str, from_here: bool = False) -> SimExecutor:
        """Return what moves a group of joints. Raises UnknownNameError where the robot has no such group."""
        made = SimExecutor(self, self._robot.group(group))
        made.from_here = from_here
        return made

    def hand(self, group: str) -> SimHand:
        """Return what moves the fingers of a group, likewise."""
        return SimHand(self, self._robot.group(group))

    def camera(self, name: str) -> SimCamera:
        """Return a camera. Raises UnknownNameError where the world has no such camera."""
        cameras = {camera.name: camera for camera in self.spec.cameras}
        if name not in cameras:
            raise UnknownNameError("camera", name, cameras)
        return SimCamera(self, cameras[name])

    def entered(self, node: str) -> None:
        """Say that a node of the task begins: faults may wait for that."""
        self.ask("entered", node=node)

    def settle(self, seconds: float | None = None) -> None:
        """Let simulated time pass, or objects come to rest, and wait. Raises SimulatorLostError where it ended."""
        wait = self.move("wait", seconds=seconds)
        wait.wait()
        wait.result()

    @contextmanager
    def filmed(self, view: str, video: Path | None = None, picture: Path | None = None) -> Iterator[None]:
        """Film the world while the block runs, 25 frames a second of simulated time, and take a picture in the end.

        Raises GripError where `view` is no camera of the world (empty for the first one), nor six numbers `X,Y,Z,X,Y,Z`
        from where to where, or a file can't be written: `video` is an .mp4, `picture` a .png or .jpg.
        """
        place = _viewpoint(view or next((camera.name for camera in self.spec.cameras), ""))
        film, still = (None if file is None else str(file.absolute()) for file in (video, picture))
        self.ask("film", view=place if isinstance(place, str) else asdict(place), video=film, picture=still)
        try:
            yield
        finally:
            try:
                self.ask("end_film")
            except GripError as error:  # the run itself has gone well, or has said what went wrong
                _log.warning("the film has no end: %s", error)

    def kept(self) -> dict[str, Array]:
        """Return everything that moves in the world, and how, for `put_back` in another process."""
        return dict(self.ask("kept").fields["kept"])

    def put_back(self, kept: Mapping[str, Array], cancel: bool = False) -> None:
        """Bring everything to where it was kept.

        Args:
            cancel: what moves is canceled; else it mustn't.

        Raises:
            GripError: it was kept in another world, or something moves.
        """
        self.ask("put_back", kept=dict(kept), cancel=cancel)

    def spawn(self, spec: ObjectSpec) -> None:
        """Add an object. Raises GripError where something has its name."""
        self.ask("spawn", spec=TypeAdapter(ObjectSpec).dump_python(spec, mode="json"))
        self.spec = replace(self.spec, objects=(*self.spec.objects, spec))

    def remove(self, name: str) -> None:
        """Take an object away. Raises GripError where there is no such object."""
        self.ask("remove", name=name)
        self.spec = replace(self.spec, objects=tuple(each for each in self.spec.objects if each.name != name))

    def inject(self, name: str, fault: Fault) -> None:
        """Have something go wrong from now on. Raises GripError where it names what isn't there."""
        self.ask("inject", name=name, fault=fault.model_dump(mode="json", exclude_defaults=True))

    def step(self, steps: int) -> None:
        """Let steps of `spec.dt` pass in a pause. Raises GripError where there is none."""
        self.ask("step", steps=steps)

    def pause(self) -> None:
        self.ask("pause")
        self.clock.hold(True)

    def resume(self) -> None:
        self.clock.hold(False)
        self.ask("resume")

    def keep_to_simulated(self, only: bool) -> None:
        self.clock.keep_to_simulated(only)


def _viewpoint(view: str) -> str | CameraSpec:
    """Return the camera that looks from three of six numbers to the other three [m], or what is a camera's name."""
    try:
        x, y, z, *target = (float(word) for word in view.split(","))
        return CameraSpec("view", 640, 480, 0.8, (x, y, z), far=10.0, target=(target[0], target[1], target[2]))
    except (ValueError, IndexError):
        return view


def start_simulation(spec: WorldSpec, pace: float | None = None, hold: int | None = None) -> Simulation:
    """Start a simulator in a process of its own and let its objects come to rest.

    Args:
        pace: simulated seconds per second; None for as fast as it goes.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.

    Raises:
        SimulatorLostError: it can't be started; the message holds what it printed.
        UnknownNameError, ValueError: there is no such robot; the pace isn't positive.
    """
    simulation = Simulation(spec, pace, hold)
    try:
        simulation.settle()
    except BaseException:
        simulation.close()
        raise
    return simulation
