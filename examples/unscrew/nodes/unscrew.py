"""Nodes for `tasks/unscrew.yaml`: seeing a bottle's cap, holding the bottle, and turning the cap with three fingertips.

The fingertips stand on a circle around the cap, in the hand's grasp frame: the thumb on one side, two fingers on the
other. They close on the rim, go around by 50 degrees, let go, and go back: a ratchet. The arm doesn't move meanwhile.
"""

from __future__ import annotations

import numpy as np

import grip_bt as grip
from grip_bt.base.failures import NoGraspError
from grip_bt.base.values import Grasp, JointState, PointCloud, Pose
from grip_bt.base.values.pose import quaternion_of

CENTRE = np.array([0.028, -0.025, 0.104])
"""Where the cap is in the grasp frame of an Allegro hand that turns it, the palm facing it [m]."""
PLACES = {"index": -40.0, "middle": 40.0, "thumb": 180.0}
"""Where fingertips are on the circle [degrees]."""
TIP = 0.012
"""Radius of a fingertip [m]."""
WIDE = 0.042
"""Radius of the circle of open fingertips [m]."""
MORE = 0.006
"""How much closer than the thumb, which reaches no further, two fingertips aim where they press [m]."""
TOP = 0.008
"""Points that are at most so far below the highest one are of the cap [m]."""


@grip.leaf("unscrew/find_cap", outputs={"cap": Pose}, codes=("no_grasp",))
def find_cap(cloud: PointCloud, *, x: list[float], y: list[float]) -> Pose:
    """Return the middle of the top of the highest thing in a part of the table, x from - to and y from - to [m]."""
    points = cloud.points
    inside = (points[:, 0] > x[0]) & (points[:, 0] < x[1]) & (points[:, 1] > y[0]) & (points[:, 1] < y[1])
    points = points[inside & (points[:, 2] > 0.05)]
    if len(points) < 10:
        raise NoGraspError(f"no bottle is seen between x {x} and y {y} [m]")
    cap = points[points[:, 2] > np.percentile(points[:, 2], 98) - TOP]
    x_middle, y_middle = (cap[:, :2].min(axis=0) + cap[:, :2].max(axis=0)) / 2
    return Pose((x_middle, y_middle, float(np.median(cap[:, 2]))))


@grip.leaf("unscrew/ways", outputs={"holding": list[Grasp], "turning": list[Grasp]}, quick=True)
def ways(
    cap: Pose, *, height: float = 0.05, below_top: float = 0.009, back: float = 0.12, lift: float = 0.06
) -> dict[str, list[Grasp]]:
    """Say how the two hands may stand, and that they come from `back` [m] away: the gripper around the bottle, level.

    The other palm faces down on the cap, its fingers turned about the vertical in one way or another; its lift ends
    `lift` [m] higher.
    """
    x, y, top = cap.position
    holding = []
    for turn in (0.0, 0.35, -0.35, 0.7, -0.7):
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
    return {"holding": holding, "turning": turning}


def circle(angle: float, radius: float) -> dict[str, list[float]]:
    """Return where fingertips are in the grasp frame [m], turned clockwise, as seen from above [degrees]."""
    found = {}
    for finger, place in PLACES.items():
        turned = np.radians(place + angle)
        away = radius - (MORE if finger != "thumb" and radius < WIDE else 0.0)
        found[finger] = (CENTRE + [away * np.cos(turned), away * np.sin(turned), 0.0]).tolist()
    return found


@grip.leaf("unscrew/around_cap", codes=("no_ik", "aborted"))
async def around_cap(context: grip.Context, *, hand: str, angle: float = 24.0, radius: float = 0.042) -> None:
    """Have the fingertips stand around the cap, not touching it."""
    await _go(context, hand, circle(angle, radius), 1.0)


@grip.leaf("unscrew/ratchet", codes=("no_ik", "aborted"))
async def ratchet(
    context: grip.Context,
    *,
    hand: str,
    times: int = 3,
    angle: float = 24.0,
    cap_radius: float = 0.02,
    squeeze: float = 0.012,
    seconds: float = 0.4,
) -> None:
    """Some times: close on the rim, go around by twice an angle [degrees], let go, and go back.

    Args:
        squeeze: how much closer than the rim the fingertips aim [m]: their joints' stiffness presses.
    """
    pressed = cap_radius + TIP - squeeze
    for _ in range(times):
        for part, radius in ((1.0, pressed), (0.0, pressed), (-1.0, pressed), (-1.0, WIDE), (1.0, WIDE)):
            await _go(context, hand, circle(part * angle, radius), seconds)


@grip.leaf("unscrew/pull", outputs={"pull": float}, codes=("no_ik", "no_plan", "path_invalid", "aborted", "no_data"))
async def pull(
    context: grip.Context, *, hand: str, arm: str, radius: float = 0.02, rise: float = 0.004, enough: float = 10.0
) -> float:
    """Take the cap, go up a little, and return how much more the wrist bears in z: its weight, or the thread's pull.

    A cap that is held back by `enough` [N] is let go, and the hand goes down again.
    """
    mover = context.arm(arm)
    await _go(context, hand, circle(24.0, radius), 0.6)
    there, before = mover.grasp_pose(), mover.wrench()
    await mover.execute(await mover.plan_straight([there.moved((0.0, 0.0, rise))]))
    bears = float((mover.wrench() - before)[2])
    if bears < -enough:
        await _go(context, hand, circle(24.0, WIDE), 0.6)
        await mover.execute(await mover.plan_straight([there]))
    return bears


async def _go(context: grip.Context, hand: str, tips: dict[str, list[float]], seconds: float) -> JointState:
    fingers = context.hand(hand)
    named = {name: place for name in fingers.fingers() for tip, place in tips.items() if name.endswith(tip)}
    posture = await context.run_in_worker(lambda: fingers.fingertip_posture(named))
    return await fingers.move(posture, seconds=seconds)


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
