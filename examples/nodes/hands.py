"""Nodes that propose grasps for whatever hand there is, and that shake what was taken; for `tasks/lift_and_shake.yaml`.

All that is known of the hand are its spans: how wide, where and how deep its fingers reach around a thing. A pinch
takes a thing between the tips, the hand turned so that they close level across it: from above, and a gripper also from
the side and aslant, which takes what is high nearer to its middle. A wrap takes an upright thing from the side: palm to
it, fingers around it; only a hand of more than two fingers does that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

import grip_bt as grip
from grip_bt.base.arrays import Array
from grip_bt.base.failures import NoGraspError, NoIkError, OutOfLimitsError, PathInvalidError
from grip_bt.base.ports import Arm, Hand
from grip_bt.base.values import Grasp, JointState, Plan, PointCloud, Pose, Trajectory
from grip_bt.base.values.joints import Span
from grip_bt.nodes.objects import SEEN

ROOM = 0.005
"""Between each finger and a thing, while the hand comes [m]."""
GAP = 0.003
"""Of the hand above the table, and of a thing from the palm [m]."""
HOLD = 0.006
"""Least height of a thing that is between the tips [m]."""
BESIDE_THUMB = 0.018
"""How far a wrapped thing lies along the fingers from the grasp frame, at least: the thumb's root is high [m]."""
HIGHEST, HIGHEST_ROUND = 0.8, 0.65
"""Round tips meet a thing below these parts of its height: what is round would be pressed down and away."""
OWN = 1e3
"""No limit but the hand's own [N m]."""
PINCH = ("pinch_open", "pinch_closed")
"""Postures between which a hand's fingertips press straight against its thumb's, where it has such."""
OFF = 0.15
"""How far off a thing's middle it is wrapped at most, as a part of its height."""
ROUND, AS_HIGH = 0.15, 0.25
"""What is as high as it is wide, but for this, and at its sides lower than its top by this part, is round."""
LOW = 0.3
"""Fingertips go so deep around what is round, as a part of its height: they carry it then."""
FILLED = 0.7
"""What is thinner than this part of the hollow between palm and closed fingers stands in there untouched."""
TURNS = np.radians((0, 15, -15, 30, -30))
"""From a face of a thing's box; what is round has no face."""
SLOPES = np.radians((10, 45))
"""How steeply a gripper comes to a thing from the side [rad]."""
ASIDE = 0.15
"""What a grasp from the side has to be better by: the arm has less room there."""
UP = np.array([0.0, 0.0, 1.0])
CELL, FINGER = 0.004, 0.01
"""What was seen counts once in each square of this edge; and half of how broad a finger is [m]."""


class Local(NamedTuple):
    """A thing where fingers close on it: the middle between them, x and y, its width there, and its height [m].

    It is infinitely wide where fingers can't stay.
    """

    middle: Array
    width: float
    top: float
    round: bool = False


class Spans(NamedTuple):
    """What a hand's fingers do: press by their tips against the thumb's, and close around something.

    A gripper's two press one against the other, and close around nothing.
    """

    tips: Sequence[Span]
    around: Sequence[Span] = ()

    @classmethod
    def of(cls, hand: Hand) -> Spans:
        """Ask a hand for them."""
        if len(hand.fingers()) < 3:
            return cls(hand.spans())
        return cls(hand.spans(*PINCH) if PINCH[0] in hand.named_states() else hand.spans(), hand.spans())


@dataclass(frozen=True, slots=True)
class Thing:
    """An upright box around something on a table.

    Attributes:
        size: edge lengths, shape (3,) [m].
        pose: of its middle, in world.
        seen: points of it in world, from above, shape (n, 3) [m]; it is taken for its box without them.
    """

    size: Array
    pose: Pose
    seen: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def floor(self) -> float:
        """Height that it stands at [m]."""
        return float(self.pose.position[2] - self.size[2] / 2)

    def width(self, direction: Array) -> float:
        """Return its extent along a unit vector [m]."""
        return float(np.abs(self.pose.rotation().T @ direction) @ self.size)

    def heavy(self) -> Array:
        """Return x and y of its centre of mass, if it is filled evenly below what was seen [m]."""
        if not len(self.seen):
            return self.pose.position[:2]
        highest = self.seen[np.argsort(-self.seen[:, 2], kind="stable")]
        _, first = np.unique(np.floor(highest[:, :2] / CELL), axis=0, return_index=True)
        return np.asarray(np.average(highest[first, :2], axis=0, weights=highest[first, 2] - self.floor))

    def stands(self) -> bool:
        """Tell whether it can be taken around: it doesn't roll, and isn't much narrower in its upper half."""
        if not len(self.seen):
            return True
        axes, edges = self.pose.rotation()[:2, :2], self.size[:2]
        upper = self.seen[self.seen[:, 2] > self.pose.position[2], :2] @ axes
        rolls = self.local(self.heavy(), self.pose.rotation()[:, int(edges.argmin())]).round
        full = len(upper) > 0 and (np.ptp(upper, axis=0) > FILLED * edges).all()
        return bool(full) and not (rolls and edges.max() > (1 + AS_HIGH) * edges.min())

    def local(self, spot: Array, across: Array) -> Local:
        """Return what fingers would meet that close along a horizontal unit vector at a spot, x and y [m]."""
        along = np.cross(UP, across)[:2]
        there = self.seen[np.abs((self.seen[:, :2] - spot) @ along) < FINGER]
        if len(there) < 3:
            return Local(spot, self.width(across), float(self.size[2]))
        top = float(there[:, 2].max()) - self.floor
        there = there[there[:, 2] > self.floor + top / 2 - FINGER]  # what is below the tips is in nobody's way
        ways, beyond = (there[:, :2] - spot) @ across[:2], (there[:, :2] - spot) @ along > 0
        sides = [float(np.ptp(half)) for half in (ways[beyond], ways[~beyond]) if len(half)]
        if max(sides) - min(sides) > FINGER:  # fingers would slide off to where it is narrower
            return Local(spot, np.inf, top)
        middle, width = spot + (ways.max() + ways.min()) / 2 * across[:2], float(np.ptp(ways)) + CELL / 2
        outer = there[np.abs(ways - (ways.max() + ways.min()) / 2) > 0.4 * width, 2]
        sloped = len(outer) > 0 and top - (float(outer.mean()) - self.floor) > ROUND * top
        return Local(middle, width, top, bool(sloped) and abs(top - width) < AS_HIGH * top)


def _seen_in(cloud: PointCloud | None, size: Array, pose: Pose) -> Array:
    if cloud is None:
        return np.zeros((0, 3))
    points: Array = np.asarray(cloud.points, float)
    inside = np.abs(pose.inverse().apply(points)) <= size / 2 + [CELL, CELL, CELL]
    return np.asarray(points[inside.all(axis=1) & (points[:, 2] > pose.position[2] - size[2] / 2 + CELL)])


@grip.leaf("hands/propose", outputs={"grasps": list[Grasp]}, codes=("no_grasp",))
def propose(
    context: grip.Context,
    cloud: PointCloud | None = None,
    *,
    hand: str = "",
    approach: float = 0.12,
    lift: float = 0.2,
    torque_limit: float = 0.0,
) -> list[Grasp]:
    """Propose grasps of everything that the scene has as seen, the best first; no torque limit is the hand's own.

    With the cloud from above, in world, things are taken where they are heavy, as wide as they are there.
    """
    scene, asked = context.scene(), context.hand(hand)
    boxes = [scene.box(name) for name in scene.names() if name.startswith(SEEN)]
    things = [Thing(*box, _seen_in(cloud, *box)) for box in boxes]
    spans, limits = Spans.of(asked), {"approach": approach, "lift": lift, "torque_limit": torque_limit}
    found = [grasp for thing in things for grasp in proposals(thing, spans, limits)]
    if not found:
        sizes = "; ".join(" x ".join(f"{1000 * edge:.0f}" for edge in thing.size) for thing in things)
        widest = 1000 * (spans.tips[0].gap - 2 * ROOM)
        raise NoGraspError(
            f"the hand {asked.name!r}, which takes what is up to {widest:.0f} mm wide, fits around nothing that was "
            f"seen: {sizes or 'there is nothing'} [mm]"
        )
    return sorted(found, key=lambda grasp: -grasp.quality)


def proposals(thing: Thing, spans: Spans, limits: Mapping[str, float]) -> list[Grasp]:
    """Return the grasps of one thing, within the leaf's `approach`, `lift` [m] and `torque_limit` [N m]."""
    tips, around = (_apart(each) for each in spans)
    ways = [*_pinches(thing, tips, bool(around)), *(_wraps(thing, around) if around and thing.stands() else ())]
    return [
        Grasp(
            pose,
            pose.moved(-limits["approach"] * direction),
            pose.moved(limits["lift"] * UP),
            pre_posture=span.posture,
            posture=closed,
            torque_limit=limits["torque_limit"] or OWN,
            width=width,
            quality=quality - 0.6 * float(np.linalg.norm(pose.position[:2])),
            provenance="hands/propose",
        )
        for pose, direction, span, closed, width, quality in ways
    ]


Way = tuple[Pose, Array, Span, JointState | None, float, float]
"""Pose, direction of the approach, fingers during it, and closed, width, quality."""


def _apart(spans: Sequence[Span]) -> Sequence[Span]:
    """Return the spans until the tips meet, or are as near as they come."""
    return spans[: next((k for k, span in enumerate(spans) if span.gap < 1e-3), None)]


def _pinches(thing: Thing, spans: Sequence[Span], thumb: bool) -> Iterator[Way]:
    for quarter in range(4):
        for turn in TURNS:
            across = thing.pose.rotation() @ [np.cos(quarter * np.pi / 2 + turn), np.sin(quarter * np.pi / 2 + turn), 0]
            along = np.cross(UP, across)
            for shift in (0.0,) if thing.width(along) < 0.08 else (0.0, 0.025, -0.025):
                local = thing.local(thing.heavy() + shift * along[:2], across)
                for found in _closing(thing, local, across, spans, thumb, [-UP]):
                    yield _worse(found, 10 * abs(shift) + 0.3 * abs(turn))
            if not thumb:
                ways = [np.cos(slope) * side - np.sin(slope) * UP for slope in SLOPES for side in (along, -along)]
                whole = Local(thing.pose.position[:2], thing.width(across), float(thing.size[2]))
                for found in _closing(thing, whole, across, spans, thumb, ways):
                    yield _worse(found, 0.3 * abs(turn))


def _worse(way: Way, by: float) -> Way:
    return *way[:-1], way[-1] - by


def _closing(
    thing: Thing, local: Local, across: Array, spans: Sequence[Span], thumb: bool, approaches: Sequence[Array]
) -> Iterator[Way]:
    """Yield how the tips of a hand close along a horizontal unit vector on a thing, coming as `approaches` say."""
    opened = [span for span in spans if span.gap >= local.width + 2 * ROOM]
    if not opened:
        return
    held = _near(spans, local.width)
    middle, top = np.array([*local.middle, thing.pose.position[2]]), float(thing.size[2])
    for inward in approaches:
        away = 1 - float(inward[:2] @ middle[:2]) / float(np.linalg.norm(middle[:2]))
        above = inward[2] < -0.99
        if away > 1 and not above:
            continue  # the hand would come towards the robot
        rotation = _turned(held, across, inward)
        reach = [float(-((span.corners - held.middle) @ rotation.T)[:, 2].min()) for span in (opened[-1], held)]
        deep = max(-top if thumb else 0.0, thing.width(inward) / 2 - held.depth + GAP)
        highest = (HIGHEST_ROUND if local.round else HIGHEST) if thumb else 1.0
        low = LOW if thumb and local.round else 0.5
        height = max(low * local.top, float(middle[2] - deep * inward[2]) - thing.floor, max(reach) + GAP)
        if height - max(reach) * above > local.top - HOLD or height > highest * local.top:
            continue
        foot = middle - deep * inward
        foot[2] = thing.floor + height
        closed = held.squeezing if thumb else None  # closed all the way, three fingers push a thumb aside
        quality = 1.5 - abs(height - top / 2) / top - (0.0 if above else ASIDE * (1 + away)) - 4 * local.width
        yield _pose(rotation, foot - rotation @ held.middle), inward, opened[-1], closed, local.width, quality


def _near(spans: Sequence[Span], gap: float) -> Span:
    return min(spans, key=lambda span: abs(span.gap - gap))


def _turned(span: Span, across: Array, inward: Array) -> Array:
    """Return the hand's rotation with which it points along `inward`, and the tips close along a unit vector."""
    own = np.stack([span.axis, np.cross(span.inward, span.axis), span.inward], axis=1)
    world = np.stack([across, np.cross(inward, across), inward], axis=1)
    return np.asarray(world @ own.T)


def _pose(rotation: Array, position: Array) -> Pose:
    return Pose.from_matrix(np.block([[rotation, position[:, None]], [np.zeros(3), 1.0]]))


def _wraps(thing: Thing, spans: Sequence[Span]) -> Iterator[Way]:
    opened, top, centre = spans[0], float(thing.size[2]), thing.pose.position
    hollow = spans[-1].middle[2]
    clear = float((opened.middle - opened.gap / 2 * opened.axis)[0]) + ROOM  # of the thumb, on the way to the palm
    outward = centre[:2] / np.linalg.norm(centre[:2])
    for quarter in range(4):
        for turn in TURNS:
            z = thing.pose.rotation() @ [np.cos(quarter * np.pi / 2 + turn), np.sin(quarter * np.pi / 2 + turn), 0]
            width, deep = thing.width(np.cross(UP, z)), thing.width(z)
            held = _near(spans, width)
            if width > min(opened.gap - ROOM, 2 * held.depth) or thing.size[:2].min() < FILLED * hollow:
                continue  # too wide, or for the tips to come around its middle, or so thin that it isn't touched
            thumb = held.middle[1]
            for flip in (1.0, -1.0):
                y = flip * UP
                rotation = np.stack([np.cross(y, z), y, z], axis=1)
                height = max(top / 2 - flip * thumb, GAP - float((flip * opened.corners[:, 1]).min()))
                off = abs(height + flip * thumb - top / 2)
                if off > OFF * top:  # there the thumb and the fingers against it would close beyond the thing's top
                    continue
                palm = np.array([*centre[:2], thing.floor + height]) - (deep / 2 + GAP) * z
                pose = _pose(rotation, palm - max(BESIDE_THUMB, clear + width / 2) * rotation[:, 0])
                yield pose, z, opened, None, width, 1.0 + float(z[:2] @ outward) - 10 * off - 2 * abs(turn)


@grip.leaf("hands/squeeze", codes=("no_contact",))
async def squeeze(context: grip.Context, grasp: Grasp, *, hand: str = "") -> None:
    """Press what a hand has closed on, wherever it is touched, so that the forces of thumb and fingers balance.

    Until here each finger pressed as far as it was off from where it would have met the thing.
    """
    asked = context.hand(hand)
    if grasp.posture is None:
        return
    aimed = grasp.posture
    met = min(Spans.of(asked).tips, key=lambda span: float(np.abs(span.squeezing.position - aimed.position).sum()))
    for _ in range(2):
        here = asked.state().ordered(aimed.names)
        await asked.close(JointState(aimed.names, here + aimed.position - met.posture.position))


SAMPLES = 100
"""Points of a shake per second."""
ASTEP = 0.06
"""How far an arm goes to where it has more room [m]."""
DEGREE = 4
"""Of the polynomials that stand for the joints along some centimetres."""


@grip.leaf(
    "hands/shake",
    codes=("no_ik", "no_plan", "path_invalid", "out_of_limits", "start_in_collision", "goal_in_collision", "aborted"),
)
async def shake(
    context: grip.Context,
    *,
    arm: str = "",
    amplitude: float = 0.025,
    frequency: float = 1.5,
    seconds: float = 1.0,
    ramp: float = 1.0,
    slow_down: bool = False,
) -> None:
    """Shake the hand along x, y and z of the world, one after the other, to each side [m], so often [1/s], so long [s].

    `ramp` periods more at each end let it grow and sink. An arm that isn't quick enough fails with `out_of_limits`, or
    shakes as quickly as it can where it may `slow_down`.
    """
    mover = context.arm(arm)
    for offset in amplitude * np.eye(3):
        await mover.execute(await _swing_in_place(mover, offset, (1 / frequency, seconds, ramp), slow_down))


async def _swing_in_place(mover: Arm, offset: Array, timing: tuple[float, float, float], slow_down: bool) -> Plan:
    """Plan one to and fro; where the arm can't reach both sides, or not so quickly, go where it has more room first."""
    outward = mover.grasp_pose().position * [1, 1, 0]
    outward /= np.linalg.norm(outward)
    hindered: Exception | None = None
    for step in (0 * UP, -ASTEP * UP, -ASTEP * outward, 2 * ASTEP * outward):
        try:
            there = mover.grasp_pose().moved(step)
            if step.any():
                await mover.execute(await mover.plan_straight([there]))
            forth, back = [await mover.plan_straight([there.moved(side * offset)]) for side in (1, -1)]
            way = swing(back.trajectory, forth.trajectory, *timing)
            return await mover.plan_from_trajectory(way, slow_down=slow_down)
        except (NoIkError, OutOfLimitsError, PathInvalidError) as error:
            hindered = error
    assert hindered is not None
    raise hindered


def swing(back: Trajectory, forth: Trajectory, period: float, seconds: float, ramp: float = 1.0) -> Trajectory:
    """Return the motion to and fro over two straight lines that begin at its middle; `ramp` is in periods."""
    sides = (-_shares(back.positions)[:0:-1], _shares(forth.positions))
    way = np.concatenate([back.positions[:0:-1], forth.positions])
    degree = min(DEGREE, len(way) - 1)
    joints = np.polynomial.polynomial.polyfit(np.concatenate(sides), way - forth.positions[0], degree)
    joints[0] = 0.0  # where the lines meet
    growing = ramp * period
    times = np.arange(round((seconds + 2 * growing) * SAMPLES) + 1) / SAMPLES
    end = np.minimum(times, times[-1] - times) / growing
    grown = np.where(end < 1, (3 - 2 * end) * end**2, 1.0)
    growth = np.where(end < 1, 6 * end * (1 - end), 0.0) / growing * np.where(times < times[-1] / 2, 1.0, -1.0)
    angle = 2 * np.pi * times / period
    place = grown * np.sin(angle)
    speed = growth * np.sin(angle) + grown * 2 * np.pi / period * np.cos(angle)
    powers = place[:, None] ** np.arange(degree + 1)
    slopes = np.arange(1, degree + 1) * powers[:, :-1] * speed[:, None]
    return Trajectory(forth.names, times, forth.positions[0] + powers @ joints, slopes @ joints[1:])


def _shares(way: Array) -> Array:
    """Return how far along a path of joints each of its points lies, from 0 to 1."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    return np.asarray(lengths / lengths[-1])
