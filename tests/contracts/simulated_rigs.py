"""Rigs over a running simulation, at its own pace: in the middle of a motion is in the middle for us too."""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial

import numpy as np
from contract_rigs import PATIENT, ArmRig, ExecutorRig, HandRig, Patient
from patience import PATIENCE

from grip_bt.base.errors import GripError
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.planning.service import PlanningProcess
from grip_sim.simulation import Simulation, start_simulation
from grip_sim.specs import ObjectSpec, WorldSpec

AT = np.array([0.2319, 0.6334, -0.4097, -2.4792, 2.2391, 1.4242, -1.3702])
"""Arm positions at which the open hand surrounds what stands at `SPOT` [rad]."""
SPOT = Pose([0.55, 0.05, 0.09])
THING = ObjectSpec("thing", "cylinder", 0.03, 0.18, (0.9, 0.45, 0.09))


class Shared:
    """A simulation that tests use one after the other; each finds it as the first one did.

    Args:
        spec: its world.
        prepare: brings a new one to where tests begin.
    """

    def __init__(self, spec: WorldSpec, prepare: Callable[[Simulation], None] = lambda simulation: None):
        self._spec, self._prepare = spec, prepare
        self._simulation: Simulation | None = None
        atexit.register(self._close)

    @contextmanager
    def borrowed(self) -> Iterator[Simulation]:
        """Lend it; what a test leaves moving, paused or lost doesn't reach the next one."""
        if self._simulation is None or not self._put_back(self._simulation):
            self._close()
            self._simulation = start_simulation(self._spec, pace=1.0)
            self._prepare(self._simulation)
            self._begin = self._simulation.kept()
        yield self._simulation

    def _put_back(self, simulation: Simulation) -> bool:
        try:
            simulation.resume()
            simulation.executor("arm").stop()
            simulation.hand("hand").stop()
            simulation.settle(0.5)
            simulation.put_back(self._begin)
        except GripError:
            return False
        return True

    def _close(self) -> None:
        if self._simulation is not None:
            self._simulation.close()
            self._simulation = None


def reach(simulation: Simulation) -> None:
    arm = simulation.executor("arm")
    home, way = arm.state(), np.linspace(0, 1, 41)[:, None]
    there = arm.execute(Trajectory(home.names, 2 * way[:, 0], home.position + (AT - home.position) * way))
    assert there.wait(PATIENCE)
    there.result()


@cache
def panda_planner() -> PlanningProcess:
    """Return the planner of all tests: it keeps nothing of what it is asked."""
    planner = PlanningProcess(build_robot("panda_allegro"))
    atexit.register(planner.close)
    return planner


TABLE, SURROUNDED = Shared(WorldSpec()), Shared(WorldSpec(objects=(THING,)), reach)


@contextmanager
def simulated_executor() -> Iterator[ExecutorRig]:
    with TABLE.borrowed() as simulation:
        executor = simulation.executor("arm")
        home = executor.state()
        goal = JointState(home.names, home.position + [0.5, 0, 0.2, 0, 0, 0, 0.4])
        limits = build_robot("panda_allegro").acceleration_limits
        yield ExecutorRig(executor, simulation.settle, goal, braking=np.array([limits[name] for name in home.names]))


@contextmanager
def simulated_hand_port() -> Iterator[HandRig]:
    """A hand beside a spot on the table; only its fingers close, since they would meet the thumb."""
    states = build_robot("panda_allegro").named_states["hand"]
    opened, closed = states["open"], states["closed"]
    thumb = set(opened.names[-4:])
    pairs = zip(opened.names, opened.position, closed.ordered(opened.names), strict=True)
    part = JointState(opened.names, [o if name in thumb else c for name, o, c in pairs])
    with SURROUNDED.borrowed() as simulation:
        hand = simulation.hand("hand")

        def take() -> None:
            simulation.referee.move_object("thing", Pose(THING.position))
            simulation.settle(0.5)

        offer = partial(simulation.referee.move_object, "thing", SPOT)
        yield HandRig(hand, simulation.settle, opened, part, offer, take, braking=40.0)


@contextmanager
def commanded_simulated_hand() -> Iterator[HandRig]:
    with simulated_hand_port() as rig:
        states = build_robot("panda_allegro").named_states["hand"]
        yield HandRig(
            HandCommander("right", rig.port, states), rig.let_pass, rig.open, states["closed"], rig.offer, rig.take
        )


@contextmanager
def commanded_simulated_arm() -> Iterator[ArmRig]:
    """The real commander, planning in its process, on simulated joints."""
    from grip_bt.commanders.arm import ArmCommander, ArmSetup
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_bt.commanders.scene import PlanningScene

    model, spec = RobotModel(build_robot("panda_allegro")), WorldSpec()
    with TABLE.borrowed() as simulation:
        executor, hand = simulation.executor("arm"), simulation.hand("hand")
        boxes = {box.name: (box.size, box.pose) for box in spec.boxes}
        scene = PlanningScene({"hand": lambda: model.grasp_pose(executor.state())}, boxes)
        arm = ArmCommander(
            ArmSetup("right", hand="hand", settings=PATIENT),
            model,
            Patient(panda_planner()),
            executor,
            scene,
            lambda: [hand.state()],
        )
        home = executor.state()
        away = JointState(home.names, home.position + [0.5, 0, 0.3, 0, 0, 0.2, 0])
        yield ArmRig(arm, simulation.settle, away, np.array([0.0, 0.02, -0.1]))
