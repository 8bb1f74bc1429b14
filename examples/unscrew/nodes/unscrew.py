"""Nodes for `tasks/unscrew.yaml`: seeing a bottle's cap, where hands stand, holding the bottle, driving the fingers.

How three fingertips turn a cap is for the hand's own controller to know, `components/finger_controller`:
`unscrew/drive` carries what is measured to it and its targets to the hand.
"""

from __future__ import annotations

import numpy as np

import grip_bt as grip
from grip_bt.base.values import Grasp, JointState, PointCloud, Pose
from grip_bt.base.values.pose import quaternion_of

CENTRE = np.array([0.038, -0.015, 0.0839])
"""Where the cap is in the grasp frame of an Allegro hand that turns it, the palm facing it [m]."""
TOP = 0.008
"""Points that are at most so far below the highest one are of the cap [m]."""
CAP = 0.015
"""A bottle without its cap is lower by so much at least [m]."""


@grip.leaf(
    "unscrew/find_cap",
    outputs={"cap": Pose, "highest": float},
    outcomes={"success": "success", "failure": "failure"},
    codes=("no_bottle", "no_cap"),
)
def find_cap(cloud: PointCloud, highest: float, *, x: list[float], y: list[float]) -> grip.End:
    """Return the middle of the top of the highest thing in a part of the table, x from - to and y from - to [m].

    Fails with `no_cap` where that is lower than what was seen before, `highest` [m]: the cap is off.
    """
    points = cloud.points
    inside = (points[:, 0] > x[0]) & (points[:, 0] < x[1]) & (points[:, 1] > y[0]) & (points[:, 1] < y[1])
    points = points[inside & (points[:, 2] > 0.05)]
    if len(points) < 10:
        return grip.End("failure", code="no_bottle", message=f"no bottle is seen between x {x} and y {y} [m]")
    cap = points[points[:, 2] > np.percentile(points[:, 2], 98) - TOP]
    (x_middle, y_middle), top = (cap[:, :2].min(axis=0) + cap[:, :2].max(axis=0)) / 2, float(np.median(cap[:, 2]))
    if top < highest - CAP:
        lower = f"{1000 * (highest - top):.0f} mm lower than it was"
        return grip.End("failure", code="no_cap", message=f"the bottle is {lower}: its cap is off")
    return grip.End("success", cap=Pose((x_middle, y_middle, top)), highest=max(top, highest))


@grip.leaf("unscrew/ways", outputs={"bottle": Pose, "holding": list[Grasp], "turning": list[Grasp]}, quick=True)
def ways(
    cap: Pose, *, height: float = 0.05, below_top: float = 0.006, back: float = 0.12, lift: float = 0.06
) -> dict[str, Pose | list[Grasp]]:
    """Say where the bottle's middle is, and how two hands may stand at it, coming from `back` [m] away.

    The gripper goes around the bottle, level. The other palm faces down on the cap, its fingers turned about the
    vertical in one way or another; its lift ends `lift` [m] higher.
    """
    x, y, top = cap.position
    holding = []
    for turn in (0.0, 0.36, -0.36, 0.72, -0.72):
        pose = Pose((x, y, height), quaternion_of(0.0, np.pi / 2, turn))
        begin = pose.moved((-back * np.cos(turn), -back * np.sin(turn), 0.0))
        holding.append(Grasp(pose, begin, pose.moved((0, 0, 0.005)), quality=-abs(turn)))
    turning, down = [], np.array([0.0, 0.0, -1.0])
    for yaw in (2.6, 3.7, 2.1, 4.2):
        along, place = np.array([np.cos(yaw), np.sin(yaw), 0.0]), np.eye(4)
        place[:3, :3] = np.stack([along, np.cross(down, along), down], axis=1)
        place[:3, 3] = np.array([x, y, top - below_top]) - place[:3, :3] @ CENTRE
        pose = Pose.from_matrix(place)
        turning.append(Grasp(pose, pose.moved((0, 0, back)), pose.moved((0, 0, lift)), quality=-yaw))
    return {"bottle": Pose((x, y, 0.07)), "holding": holding, "turning": turning}


@grip.leaf("unscrew/pull", outputs={"pull": float}, codes=("no_data",), quick=True)
def pull(context: grip.Context, zero: list[float], *, arm: str) -> float:
    """Return how much a wrist bears upwards [N], over what it bore before the fingers gripped, `zero`.

    What holds a cap back pulls down. Fingers that have just closed press the cap down by some newtons, which the bottle
    bears: what is measured then is no zero.
    """
    return float(context.arm(arm).wrench()[2] - zero[2])


@grip.leaf("unscrew/drive", codes=("out_of_reach", "server_lost", "timed_out", "bad_reply", "aborted"))
class Drive(grip.AsyncLeaf):
    """Let the hand's own controller carry out a command, cycle after cycle: measured joints in, joint targets out."""

    hand: grip.Param[str]
    command: grip.Param[str]
    period: grip.Param[float] = 0.05
    turned: grip.Output[float]

    async def run(self) -> grip.End:
        """Ask for targets once in a period [s], and have the fingers go there meanwhile; other joints aren't ours."""
        hand, controller = self.context.hand(self.hand), self.context.component("finger_controller")
        going, done = 0, 1
        reply, outcome = {}, going
        while outcome == going:
            measured = hand.state()
            reply = await controller.call({"input": measured, "command": self.command, "period": self.period})
            outcome, targets = reply["outcome"], reply["returned_object"].as_mapping()
            ours = {name: position for name, position in targets.items() if name in measured.names}
            hand.move(JointState.from_mapping(ours), seconds=self.period)
            self.tell(f"{self.command}: {np.degrees(reply['turned']):.0f} degrees")
            await self.sleep(self.period)
        if outcome != done:
            return grip.End("failure", code="out_of_reach", message="the fingertips can't go where the controller aims")
        return grip.End("success", turned=reply["turned"])


@grip.leaf("unscrew/hold", outcomes={"failure": "failure"}, codes=("no_contact", "lost_contact"))
class Hold(grip.AsyncLeaf):
    """Hold with a force until interrupted, with half as much again whenever something slips, up to `most`.

    The hand regulates its force by itself; this looks after it.
    """

    hand: grip.Param[str]
    force: grip.Param[float] = 15.0
    most: grip.Param[float] = 40.0
    slip: grip.Param[float] = 0.003

    async def run(self) -> grip.End:
        """Close, and look twenty times a second [N, m/s]."""
        gripper, force = self.context.hand(self.hand), self.force
        await gripper.close(force=force)
        while gripper.contacts():
            if force < self.most and max(gripper.slips().values(), default=0.0) > self.slip:
                force = min(1.5 * force, self.most)
                await gripper.close(force=force)
            self.tell(f"{force:.0f} N")
            await self.sleep(0.05)
        return grip.End("failure", code="lost_contact", message="the gripper holds nothing any more")
