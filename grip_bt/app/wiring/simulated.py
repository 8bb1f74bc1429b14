"""A project's robot in simulation: the simulator's process, the planner's, and the commanders over them."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace

from grip_bt.commanders.planning.requests import PlanningService
from grip_bt.runtime.lockstep import InTurn, Lockstep
from grip_sim import start_simulation

from ..project.faults import check, faults_of_faults, faults_of_simulation, jerks_of_arms
from ..project.worlds import regions_of, room_of, world_of
from .commanders import PlannedRobot, commanded, with_move_group
from .parts import Opening, Resources


class SimulatedBackend:
    """Implements `RobotBackend`: the project's world, which waits for the run unless it has a pace."""

    def open(self, opening: Opening, stack: ExitStack) -> Resources:
        """Start the simulator and the planner."""
        project, file, progress = opening.project, opening.project.file, opening.progress
        check(faults_of_simulation(project))
        progress("starting", "the simulator and the planner")
        robot = PlannedRobot.begin(opening, stack)
        jerks = jerks_of_arms(file.arms, robot.description)
        spec = replace(world_of(project, opening.seed), jerks=jerks)
        spec = replace(spec, faults={} if opening.faults is None else {**spec.faults, **opening.faults})
        check(faults_of_faults(project, spec, robot.description))
        simulation = stack.enter_context(start_simulation(spec, opening.pace, opening.hold))
        objects = ", ".join(thing.name for thing in spec.objects)
        progress("simulator", f"SAPIEN in process {simulation.pid}, world {file.world!r}: {objects}")
        plans: PlanningService = with_move_group(opening, robot.description, robot.process, stack)
        lockstep = Lockstep(simulation) if opening.pace is None else None
        if lockstep is not None:
            plans = InTurn(plans, lockstep, patient=True)
        parts = commanded(
            opening,
            robot.description,
            plans,
            {name: simulation.executor(arm.group) for name, arm in file.arms.items()},
            {name: simulation.hand(hand.group) for name, hand in file.hands.items()},
            room_of(spec),
            regions_of(spec),
        )
        cameras = {name: simulation.camera(s.camera) for name, s in file.sensors.items() if s.camera is not None}
        robot.wait_until_ready(opening)
        return replace(
            parts,
            cameras=cameras,
            pausable=(simulation,),
            clock=simulation.clock,
            lockstep=lockstep,
            world=simulation,
        )
