"""The robot of a project in simulation: the simulator's process, the planner's, and the commanders over them."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from importlib.util import find_spec

from grip_bt.base.errors import GripError, MissingPartError
from grip_bt.base.values import Pose
from grip_bt.runtime.lockstep import InTurn, Lockstep

from ..project.faults import check_arms, check_world, jerks_of_arms
from ..project.folder import Project
from .commanders import open_commanders
from .parts import Progress, Resources
from .planners import planners_in_force, with_move_group


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
        DocumentError: the file of the room can't be read.
    """
    file = project.file
    check_world(project)
    for library in ("pinocchio", "sapien"):  # they are imported by processes of their own
        if find_spec(library) is None:
            raise MissingPartError(f"the simulator (no module {library!r})", "pip install 'grip-bt[sim]', or make demo")
    from grip_bt.commanders.planning.service import PlanningProcess
    from grip_sim import start_simulation
    from grip_sim.specs import table_world

    progress("starting", "the simulator and the planner")
    description = project.description()
    check_arms(project, description)
    planner = stack.enter_context(PlanningProcess(description, partial(progress, "planner")))
    # It builds its model while the simulator starts.
    spec = replace(table_world(seed), robot=project.robot_source, jerks=jerks_of_arms(file.arms, description))
    simulation = stack.enter_context(start_simulation(spec, pace, hold))
    progress("simulator", f"SAPIEN in process {simulation.pid}: {', '.join(o.name for o in spec.objects)} on the table")
    plans = with_move_group(project, description, planner, stack)
    if pace is None:
        resources.lockstep = Lockstep(simulation)
        plans = InTurn(plans, resources.lockstep, patient=True)
    open_commanders(
        project,
        resources,
        description,
        plans,
        {name: simulation.executor(arm.group) for name, arm in file.arms.items()},
        {name: simulation.hand(hand.group) for name, hand in file.hands.items()},
        {box.name: (box.size, Pose(box.centre)) for box in spec.boxes()},
        seed,
    )
    resources.cameras = {
        name: simulation.camera(sensor.camera) for name, sensor in file.sensors.items() if sensor.camera is not None
    }
    resources.pausable = [simulation]
    resources.clock, resources.referee, resources.world = simulation.clock, simulation.referee, simulation
    if not planner.wait_until_ready():
        raise GripError("the planning process doesn't come up; run `grip doctor`")
    progress("planner", f"process {planner.pid}: {planners_in_force(project, description)}")
