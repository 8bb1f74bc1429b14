"""The world of the leaves' tests with the shipped fakes of an arm and a hand."""

from __future__ import annotations

from timed import ManualClock, OnClock, TimedArm, TimedHand

from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.scene import PlanningScene

OPEN, CLOSED = (JointState(("finger", "thumb"), [angle, angle]) for angle in (0.0, 1.0))
SUCCESS = ("SUCCESS", "success", None)


class Cell:
    """The world with shipped fakes, whose time the test moves."""

    def __init__(self, world, **script):
        self.clock, self.world = ManualClock(), world
        self.schedule = OnClock(self.clock)
        self.arm = TimedArm("right", Pose((0.3, -0.4, 0.5)), self.schedule, script=script)
        self.port = TimedHand(OPEN, self.schedule)
        fingers = {"finger": ("finger",), "thumb": ("thumb",)}
        self.hand = HandCommander(
            "right_hand", self.port, {"open": OPEN, "closed": CLOSED}, fingers=fingers, touch=self.port
        )
        self.scene = PlanningScene({"right_hand": self.arm.grasp_pose}, {"table": ((1, 1, 0.1), Pose((0.5, 0, -0.05)))})
        context = world.context
        context._arm, context._hand, context._scene, context.clock = self.arm, self.hand, self.scene, self.clock
        self.leaf, self.data = world.leaf, world.data

    def run(self, leaf, at_most=20.0, step=0.1):
        """Tick and let time pass until the leaf ends; return how."""
        for _ in range(int(at_most / step)):
            leaf.tick_once()
            if leaf.outcome is not None:
                return leaf.status.name, leaf.outcome, leaf.failure and leaf.failure.code
            self.clock.advance(step)
        raise AssertionError(f"{leaf.manifest.id} still runs after {at_most} s")
