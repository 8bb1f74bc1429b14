"""A world with one thing to grasp, and a grasp of it that was worked out once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from patience import PATIENCE

from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.commanders.description.load import build_robot
from grip_sim.simulation import Simulation
from grip_sim.specs import ObjectSpec, WorldSpec

AT = np.array([0.2319, 0.6334, -0.4097, -2.4792, 2.2391, 1.4242, -1.3702])
"""Arm positions at which the open hand surrounds what stands at `SPOT` [rad]."""
ABOVE = np.array([0.3207, 0.2176, -0.5127, -2.6136, 2.1408, 1.6650, -1.2297])
"""The same, 12 cm higher."""
SPOT = Pose([0.55, 0.05, 0.09])
ASIDE, BESIDE = Pose([0.9, 0.45, 0.09]), Pose([0.9, 0.25, 0.06])
SPEC = WorldSpec(
    objects=(
        ObjectSpec("thing", "cylinder", 0.03, 0.18, tuple(ASIDE.position.tolist())),
        ObjectSpec("other", "box", 0.03, 0.12, tuple(BESIDE.position.tolist())),
    )
)


@dataclass
class Bench:
    """A running simulation and what tests do with it."""

    simulation: Simulation

    def __post_init__(self):
        self.robot = build_robot("panda_allegro")
        self.arm, self.hand = self.simulation.executor("arm"), self.simulation.hand("hand")
        self.referee = self.simulation.referee
        self.opened, self.closed = (self.robot.named_state("hand", name) for name in ("open", "closed"))
        between = self.opened.position + 0.6 * (self.closed.position - self.opened.position)
        self.half_closed = JointState(self.opened.names, between)  # fingers and thumb don't meet yet

    def wait(self, operation: Operation[Any]) -> Any:
        assert operation.wait(PATIENCE), "it doesn't end"
        return operation.result()

    def way(self, goal, duration=1.0, start=None) -> Trajectory:
        """Return a smooth way from where the arm is."""
        part = np.linspace(0, 1, 41)
        smooth = part * part * (3 - 2 * part)
        begin = self.arm.state().position if start is None else start
        return Trajectory(self.arm.joint_names, part * duration, begin + (goal - begin) * smooth[:, None])

    def go(self, goal, duration=1.5):
        return self.wait(self.arm.execute(self.way(np.asarray(goal), duration)))

    def truth(self, name="thing"):
        return self.referee.truth()[name]

    def reset(self):
        """Bring things and hand back to where they began, wherever a test left them."""
        self.hand.stop()
        self.wait(self.hand.move(self.opened, 0.3))
        self.referee.move_object("thing", ASIDE)
        self.referee.move_object("other", BESIDE)
        self.simulation.settle(0.3)
        self.go(ABOVE)

    def grasp(self):
        """Have the hand hold the thing, 12 cm above the table."""
        self.go(AT)
        self.referee.move_object("thing", SPOT)
        self.wait(self.hand.move(self.closed, 1.2, 0.5))
        self.go(ABOVE)
