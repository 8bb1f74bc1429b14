"""The commanders of a project's arms and hands, over whatever moves their joints, and who plans for them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grip_bt.app.project import faults
from grip_bt.app.project.folder import ArmConfig, Project, ProjectFile
from grip_bt.app.project.worlds import regions_of, room_of, world_of
from grip_bt.app.wiring.parts import Opening, Resources, load_part
from grip_bt.base.errors import GripError
from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, HandPort, Touch
from grip_bt.base.values import JointState, Plan, Pose
from grip_bt.commanders.arm import ArmCommander, ArmSetup
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import joints_of_fingers, limits_of_joints, links_of_groups
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.joined import JoinedExecutor
from grip_bt.commanders.kinematics.fingertips import fingertip_posture, spans_of
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning import requests
from grip_bt.commanders.planning.service import PlanningProcess
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.scene_state import HandMount, SceneObject
from grip_bt.commanders.settings import MotionSettings, PlanningSettings
from grip_bt.commanders.taught import TaughtStates
from grip_bt.runtime.lockstep import InTurn, Lockstep
from grip_bt.task.catalog.ros_config import MOVE_GROUP
from grip_sim.simulation import Simulation, start_simulation

if TYPE_CHECKING:
    from grip_bt.ros.client.bus import Bus


@dataclass(frozen=True)
class PlannedRobot:
    """A robot whose planner is coming up: it builds its model while the rest of the robot starts."""

    description: RobotDescription
    process: PlanningProcess

    @classmethod
    def begin(cls, opening: Opening) -> PlannedRobot:
        """Verify what arms and hands name, and start the planner."""
        description = opening.project.description()
        faults.check(faults.faults_of_parts(opening.project, description))

        def start(stack: ExitStack) -> PlanningProcess:
            return stack.enter_context(PlanningProcess(description))

        process = opening.equipment.get(f"planner {description.name}", description, start)
        process.told = partial(opening.progress, "planner")
        return cls(description, process)

    def wait_until_ready(self, opening: Opening) -> None:
        """Block until the planner plans. Raises GripError: it doesn't come up."""
        if not self.process.wait_until_ready():
            raise GripError("the planning process does not start; run `grip doctor`")
        arms = opening.project.file.arms.values()
        names = sorted({settings_of(arm, self.description, 0).planner for arm in arms})
        opening.progress("planner", f"process {self.process.pid}: {', '.join(names)}")


def commanded(
    opening: Opening,
    description: RobotDescription,
    planner: requests.PlanningService,
    executors: Mapping[str, Executor],
    ports: Mapping[str, HandPort],
    room: Iterable[SceneObject] = (),
    regions: Mapping[str, tuple[Sequence[float], Pose]] | None = None,
    touch: Mapping[str, Touch] | None = None,
    wrists: Mapping[str, Callable[[], Measured]] | None = None,
) -> Resources:
    """Return the project's arms, hands and scene, with what stands in the room besides the project's `scene:`.

    Regions are (edge lengths [m], pose of the middle in world) by name; `touch` is what hands feel, `wrists` what the
    sensors at the ends of arms measure.
    """
    project, file = opening.project, opening.project.file
    model = opening.equipment.get(f"model {description.name}", description, lambda _: RobotModel(description))
    taught = TaughtStates(project.folder / faults.TAUGHT)
    joined = {name: arm.arms for name, arm in file.arms.items() if arm.arms}
    executors = {**executors, **{n: JoinedExecutor(*(executors[each] for each in arms)) for n, arms in joined.items()}}
    states = {name: executor.state for name, executor in executors.items()} | {n: p.state for n, p in ports.items()}
    scene = _scene_around(project, model, states, (*room, *project.room()), regions)
    arms = {
        name: ArmCommander(
            ArmSetup(
                name,
                arm.group,
                arm.hand or "",  # a bare arm moves, and grasps nothing
                settings_of(arm, description, opening.seed),
                faults.common_states(arm, file.arms, description),
                taught,
            ),
            model,
            planner,
            executors[name],
            scene,
            partial(_others, states, name, arm.hand or ""),
            partial(_in_world, model, executors[name], wrists[name]) if wrists and name in wrists else None,
        )
        for name, arm in file.arms.items()
    }
    return Resources(arms=arms, hands=_hands_of(file, model, ports, taught, touch or {}), scene=scene)


def _hands_of(
    file: ProjectFile,
    model: RobotModel,
    ports: Mapping[str, HandPort],
    taught: TaughtStates,
    touch: Mapping[str, Touch],
) -> dict[str, HandCommander]:
    """Return the project's hands."""
    robot = model.description
    carried_by = {arm.hand: arm.group for arm in file.arms.values()}
    return {
        name: HandCommander(
            name,
            ports[name],
            robot.named_states.get(hand.group, {}),
            fingers=joints_of_fingers(robot, hand.group),
            limits=limits_of_joints(robot, hand.group),
            taught=taught,
            reach=partial(_reached, model, hand.group, carried_by.get(name, "")),
            spans=partial(spans_of, model, hand.group, model.grasp_frame_of(carried_by.get(name, ""))),
            touch=touch.get(name),
        )
        for name, hand in file.hands.items()
    }


def _scene_around(
    project: Project,
    model: RobotModel,
    states: Mapping[str, Callable[[], JointState]],
    room: Iterable[SceneObject],
    regions: Mapping[str, tuple[Sequence[float], Pose]] | None,
) -> PlanningScene:
    """Return the scene that the robot is in, whose arms and hands are where `states` measures them."""
    arms, hands, robot = project.file.arms, project.file.hands, model.description
    carried = {arm.hand: name for name, arm in arms.items() if arm.hand}
    groups = {name: arm.group for name, arm in arms.items()} | {name: hand.group for name, hand in hands.items()}
    links = links_of_groups(robot, groups)

    def palm_of(hand: str) -> Pose:
        group = arms[carried[hand]].group if hand in carried else ""
        return model.grasp_pose(states[carried.get(hand, hand)](), group=group)

    def shapes(at: JointState | None) -> Sequence[NDArray[np.float64]]:
        return model.hulls(*(measure() for measure in states.values()), *(() if at is None else (at,)))

    return PlanningScene(
        {hand: partial(palm_of, hand) for hand in hands},
        room=room,
        links=links,
        folder=project.folder,
        carriers={
            hand: HandMount(arms[arm].group, frozenset((*links[hand], *robot.hands.get(hands[hand].group, ()))))
            for hand, arm in carried.items()
        },
        robot=shapes,
        regions=regions,
    )


Measured = Mapping[str, NDArray[np.float64]]
"""A link, or `world`, and force and torque in its axes, shape (6,)."""


def _in_world(model: RobotModel, executor: Executor, measure: Callable[[], Measured]) -> NDArray[np.float64]:
    """Return what is measured at a wrist in world's axes."""
    ((frame, wrench),) = measure().items()
    if frame == "world":
        return wrench
    places = model.link_poses(executor.state())
    if frame not in places:
        raise SensorError(f"the wrench is measured in {frame!r}, which is no link of the robot")
    return np.asarray((wrench.reshape(2, 3) @ places[frame].rotation().T).ravel())


def _reached(
    model: RobotModel,
    group: str,
    arm_group: str,
    targets: Mapping[str, Sequence[float]],
    posture: JointState,
    frame: str,
) -> JointState:
    """Return the posture that brings fingertips to positions; those in no frame are in the grasp frame of the arm."""
    places = {name: np.array(position, dtype=float) for name, position in targets.items()}
    return fingertip_posture(model, places, posture, group, frame=frame or model.grasp_frame_of(arm_group))


def _others(states: Mapping[str, Callable[[], JointState]], arm: str, hand: str) -> list[JointState]:
    """Return the measured states of an arm's hand, and of all parts that have no joint in common with the two."""
    found = [states[hand]()] if hand else []
    taken = {joint for state in (states[arm](), *found) for joint in state.names}
    for name, measure in states.items():
        state = measure() if name not in (arm, hand) else None
        if state is not None and not taken & set(state.names):
            taken |= set(state.names)
            found.append(state)
    return found


class PlannerByName:
    """Implements `planning.service.PlanningService`: a search goes to who its arm's settings name.

    Args:
        own: answers what nobody else is named for, every request about a motion that is given, and motions
            through way points (with the default planner): nobody else blends as ours does.
        others: planner's name -> who searches.
    """

    def __init__(self, own: requests.PlanningService, others: Mapping[str, requests.Searcher]):
        self._own, self._others = own, others

    def submit(self, request: requests.Request) -> Operation[Plan | requests.ChosenGrasp | None]:
        """Ask; see `PlanningService`."""
        situation = request.situation
        if isinstance(request, requests.PlanThrough) and situation.settings.planner in self._others:
            usual = situation.settings.model_copy(update={"planner": PlanningSettings().planner})
            request = replace(request, situation=replace(situation, settings=usual))
        if isinstance(request, requests.PlanTo | requests.PlanStraight | requests.ChooseGrasp):
            return self._others.get(request.situation.settings.planner, self._own).submit(request)
        return self._own.submit(request)


def with_move_group(
    opening: Opening,
    description: RobotDescription,
    own: requests.PlanningService,
    stack: ExitStack,
    bus: Bus | None = None,
) -> requests.PlanningService:
    """Return a planner that has MoveIt answer for the arms that say so.

    Args:
        bus: the connection to ROS; one of its own, in the user's domain, when there is none.

    Raises:
        MissingPartError: ROS isn't installed, or MoveIt's messages aren't and can't be built.
        UnknownNameError: an arm names a hand or a group that isn't there.
    """
    if all(arm.planner != MOVE_GROUP for arm in opening.project.file.arms.values()):
        return own
    loaded = load_part("ros", f"ROS, for `planner: {MOVE_GROUP}`", "ros")
    return PlannerByName(own, {MOVE_GROUP: loaded.open_move_group(opening.project, description, stack, bus)})


def settings_of(arm: ArmConfig, robot: RobotDescription, seed: int) -> PlanningSettings:
    """Return how an arm is planned for: its fields in `grip.yaml`, else what the robot's files say, else defaults.

    Raises:
        UnknownNameError: there is no such solver or planner.
    """
    faults.check(faults.faults_of_fields(arm, robot, "grip.yaml: arms"))

    asked = {name: getattr(arm, name) for name in MotionSettings.model_fields}
    preferred = {name: faults.field_of(arm, robot, name) for name in ("planner", "kinematics", "speed", "acceleration")}
    return PlanningSettings(**{**asked, **preferred}, seed=seed)


def open_simulated(opening: Opening, stack: ExitStack) -> Resources:
    """Start the planner and the simulator of the project's world, which waits for the run unless it has a pace."""
    project, file, progress = opening.project, opening.project.file, opening.progress
    faults.check(faults.faults_of_simulation(project))
    progress("starting", "the simulator and the planner")
    robot = PlannedRobot.begin(opening)
    world = world_of(project, opening.seed, object=opening.object)
    spec = replace(world, jerks=faults.jerks_of_arms(file.arms, robot.description))
    spec = replace(spec, faults={} if opening.faults is None else {**spec.faults, **opening.faults})
    faults.check(faults.faults_of_faults(project, spec, robot.description))

    def start(stack: ExitStack) -> Simulation:
        return stack.enter_context(start_simulation(spec, opening.pace, opening.hold))

    simulation = opening.equipment.get("simulator", (opening.pace, opening.hold), start, Simulation.lives)
    if simulation.spec is not spec:
        simulation.begin(spec)
    objects = ", ".join(thing.name for thing in spec.objects)
    progress("simulator", f"SAPIEN in process {simulation.pid}, world {file.world!r}: {objects}")
    plans: requests.PlanningService = with_move_group(opening, robot.description, robot.process, stack)
    lockstep = Lockstep(simulation) if opening.pace is None else None
    if lockstep is not None:
        plans = InTurn(plans, lockstep, patient=True)
    hands = {name: simulation.hand(hand.group) for name, hand in file.hands.items()}
    parts = commanded(
        opening,
        robot.description,
        plans,
        {name: simulation.executor(arm.group) for name, arm in file.arms.items()},
        hands,
        room_of(spec),
        regions_of(spec),
        hands,
        {name: hands[arm.hand].wrench for name, arm in file.arms.items() if arm.hand},
    )
    cameras = {name: simulation.camera(s.camera) for name, s in file.sensors.items() if s.camera is not None}
    robot.wait_until_ready(opening)
    return replace(
        parts, cameras=cameras, pausable=(simulation,), clock=simulation.clock, lockstep=lockstep, world=simulation
    )
