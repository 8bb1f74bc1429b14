"""The robot of a project in simulation: the simulator's process, the planner's, and the commanders over them."""

from __future__ import annotations

from contextlib import ExitStack

from grip_bt.errors import GripError, MissingPartError, UnknownNameError
from grip_bt.values import Pose

from .project import ArmConfig, Project
from .resources import Progress, Resources

WORLDS = ("table",)
TAUGHT = "taught.yaml"
"""File of a project in which taught states and poses are kept."""


def open_robot(
    project: Project,
    resources: Resources,
    seed: int,
    pace: float | None,
    stack: ExitStack,
    progress: Progress,
    hold: int | None = None,
) -> None:
    """Start the project's world and put its arms, hands, cameras, scene, clock and referee into `resources`.

    Args:
        project: with a robot and a world.
        resources: filled in.
        seed: of the world.
        pace: simulated seconds per second; None for as fast as it goes.
        stack: closes what was started.
        progress: told of each part that came up.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.

    Raises:
        MissingPartError: the simulator or the motion libraries aren't installed.
        UnknownNameError: the project names a world, robot, group or camera that isn't there.
    """
    file = project.file
    if file.world not in WORLDS:
        raise UnknownNameError("world", str(file.world), WORLDS, "grip.yaml")
    try:
        from grip_bt.commanders.arm import ArmCommander
        from grip_bt.commanders.hand import HandCommander
        from grip_bt.commanders.model import RobotModel
        from grip_bt.commanders.planning.requests import PlanningSettings
        from grip_bt.commanders.robot_links import joints_of_fingers, limits_of_joints, links_of_groups
        from grip_bt.commanders.robots import build_robot
        from grip_bt.commanders.scene import PlanningScene
        from grip_bt.commanders.taught import Taught
        from grip_bt.commanders.worker import PlanningProcess
        from grip_sim import start_simulation, table_world
    except ImportError as error:
        raise MissingPartError(f"the simulator ({error})", "pip install 'grip-bt[sim]', or make demo") from None

    description = build_robot(str(file.robot))
    planner = stack.enter_context(PlanningProcess(description))  # builds its model while the simulator starts
    spec = table_world(seed)
    simulation = stack.enter_context(start_simulation(spec, pace, hold))
    progress("simulator", f"SAPIEN in process {simulation.pid}: {', '.join(o.name for o in spec.objects)} on the table")
    model, taught = RobotModel(description), Taught(project.folder / TAUGHT)

    ports = {name: simulation.hand(hand.group) for name, hand in file.hands.items()}
    resources.hands = {
        name: HandCommander(
            name,
            ports[name],
            description.named_states[hand.group],
            fingers=joints_of_fingers(description, hand.group),
            limits=limits_of_joints(description, hand.group),
            taught=taught,
        )
        for name, hand in file.hands.items()
    }
    executors = {name: simulation.executor(arm.group) for name, arm in file.arms.items()}
    carried = {_hand_of(name, arm, file.hands): name for name, arm in file.arms.items()}
    scene = PlanningScene(
        {hand: lambda arm=arm: model.grasp_pose(executors[arm].state()) for hand, arm in carried.items()},
        {box.name: (box.size, Pose(box.centre)) for box in spec.boxes()},
        project.room(),
        links_of_groups(description, {name: part.group for name, part in (*file.arms.items(), *file.hands.items())}),
        project.folder,
    )
    resources.arms = {
        arm: ArmCommander(
            arm,
            model,
            planner,
            executors[arm],
            scene,
            hand,
            ports[hand].state,
            PlanningSettings(
                planner=file.arms[arm].planner,
                kinematics=file.arms[arm].kinematics,
                speed=file.arms[arm].speed,
                acceleration=file.arms[arm].acceleration,
                time_limit=file.arms[arm].planning_time,
                attempts=file.arms[arm].attempts,
                seed=seed,
            ),
            file.arms[arm].group,
            taught,
        )
        for hand, arm in carried.items()
    }
    resources.cameras = {
        name: simulation.camera(sensor.camera) for name, sensor in file.sensors.items() if sensor.camera is not None
    }
    resources.pausable = [simulation]
    resources.scene, resources.clock, resources.referee = scene, simulation.clock, simulation.referee
    if not planner.wait_until_ready():
        raise GripError("the planning process doesn't come up; run `grip doctor`")
    progress("planner", f"process {planner.pid}: {', '.join(sorted({a.planner for a in file.arms.values()}))}")


def _hand_of(name: str, arm: ArmConfig, hands: object) -> str:
    if arm.hand is None or arm.hand not in hands:  # type: ignore[operator]
        raise UnknownNameError("hand", str(arm.hand), hands, f"grip.yaml: arms/{name}/hand")  # type: ignore[arg-type]
    return arm.hand
