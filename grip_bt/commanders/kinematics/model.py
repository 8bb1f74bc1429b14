"""A robot's kinematics and collision shapes, computed from its description with pin and coal.

`RobotModel` knows all joints; `RobotModel.chain` gives the part that one group moves, with every other joint
frozen in place. Planning and collision checks run on a chain: it has 6 or 7 joints instead of 23.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from math import isfinite

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.values import JointState, Pose
from grip_bt.base.values.joints import Span

from ..description.robot import RobotDescription
from ..trajectory.limits import Limits
from .outline import Outline, corners, outlined, shape_reaches
from .shapes import simplified

GRASP_FRAME = "grasp"
_SAMPLES = 300
_ALWAYS = 0.9
"""Shapes that collide in more than this part of random configurations overlap by design of the model."""


class Chain:
    """The joints of one group; all others are frozen.

    Attributes:
        joints: names of the joints, in the order of configurations.
        model: pin's model of these joints.
        geometry: the robot's collision shapes with the pairs to check.
        limits: of these joints.
        frame: id of the group's grasp frame.
        hand: indices of the hands' shapes in `geometry`.
        links: names of the shapes' links.
    """

    def __init__(
        self,
        joints: tuple[str, ...],
        model: pin.Model,
        geometry: pin.GeometryModel,
        limits: Limits,
        hand_links: frozenset[str],
        frame: str = GRASP_FRAME,
    ):
        if tuple(model.names)[1:] != joints:
            raise ValueError(f"a chain's joints are listed from the base on, as {list(model.names)[1:]}, not {joints}")
        self.joints, self.model, self.geometry, self.limits = joints, model, geometry, limits
        self.frame = model.getFrameId(frame)
        self.data = model.createData()
        links = [link_of(model, shape) for shape in geometry.geometryObjects]
        self.hand = frozenset(k for k, link in enumerate(links) if link in hand_links)
        self.links = tuple(links)

    @cached_property
    def outline(self) -> Outline:
        """The collision shapes with each hand as one hull."""
        return outlined(self.geometry, self.hand)

    @cached_property
    def outline_reaches(self) -> Array:
        """How far each joint can move each shape of the outline; see `outline.shape_reaches`."""
        return shape_reaches(self.model, self.outline.geometry.geometryObjects)

    @cached_property
    def reaches(self) -> Array:
        """How far each joint can move each shape; see `outline.shape_reaches`."""
        return shape_reaches(self.model, self.geometry.geometryObjects)

    def grasp_pose(self, q: Array) -> pin.SE3:
        """Return the grasp frame in world for a configuration of shape (n,)."""
        pin.framesForwardKinematics(self.model, self.data, q)
        return self.data.oMf[self.frame].copy()

    def within_limits(self, q: Array, slack: float = 1e-6) -> bool:
        """Tell whether configurations, shape (..., n), respect the position limits up to `slack` [rad]."""
        return bool(np.all((q >= self.limits.lower - slack) & (q <= self.limits.upper + slack)))


class RobotModel:
    """Kinematics and collision shapes of a whole robot."""

    def __init__(self, description: RobotDescription):
        self.description = description
        self.model = pin.buildModelFromXML(description.urdf)
        self._frames = self._add_grasp_frames()
        self.data = self.model.createData()
        self._lock = threading.Lock()
        raw = pin.buildGeomFromUrdfString(self.model, description.urdf, pin.GeometryType.COLLISION)
        self.geometry = pin.GeometryModel()
        for shape in simplified(raw.geometryObjects):
            self.geometry.addGeometryObject(shape)
        self._columns = {str(n): self.model.joints[k].idx_q for k, n in enumerate(self.model.names) if k}
        rest = {n: p for n, p in description.at_rest.items() if n in self._columns}
        middle = np.clip(pin.neutral(self.model), self.model.lowerPositionLimit, self.model.upperPositionLimit)
        self._rest = self.configuration(JointState(tuple(rest), tuple(rest.values())), base=middle)
        self._drop_harmless_pairs()
        self._chains: dict[tuple[str, bytes], Chain] = {}
        self.spans: dict[tuple[str, str, tuple[str, ...], bytes], Span] = {}  # see `fingertips.spans_of`

    def configuration(self, *states: JointState, base: Array | None = None) -> Array:
        """Return a configuration of all joints, shape (nq,): `base` (or at rest), overlaid with `states`.

        Joints that mimic others follow them.

        Raises:
            ValueError: a position isn't finite.
        """
        q = np.array(self._rest if base is None else base)
        for state in states:
            for name, position in zip(state.names, state.position.tolist(), strict=True):
                if not isfinite(position):
                    raise ValueError(f"the position of joint {name!r} is {position}")
                q[self._columns[name]] = position
        for name, mimic in self.description.mimics.items():
            q[self._columns[name]] = mimic.multiplier * q[self._columns[mimic.joint]] + mimic.offset
        return q

    def grasp_pose(self, *states: JointState, group: str = "") -> Pose:
        frame = self.model.getFrameId(self.grasp_frame_of(group))
        with self._lock:  # leaves, callbacks and the scene ask from several threads
            pin.framesForwardKinematics(self.model, self.data, self.configuration(*states))
            return Pose.from_matrix(self.data.oMf[frame].homogeneous)

    def link_poses(self, *states: JointState) -> dict[str, Pose]:
        """Return where each link is in world."""
        bodies = [(k, frame.name) for k, frame in enumerate(self.model.frames) if frame.type == pin.FrameType.BODY]
        with self._lock:
            pin.framesForwardKinematics(self.model, self.data, self.configuration(*states))
            return {name: Pose.from_matrix(self.data.oMf[k].homogeneous) for k, name in bodies}

    def named_states_of(self, group: str) -> Mapping[str, JointState]:
        return self.description.named_states.get(group, {})

    def hulls(self, *states: JointState) -> list[Array]:
        """Return points of each collision shape, shape (k, 3) in world [m], whose convex hull contains the shape."""
        with self._lock:
            pin.forwardKinematics(self.model, self.data, self.configuration(*states))
            placed = [self.data.oMi[joint].copy() for joint, _ in self._shape_corners]
        return [
            points @ place.rotation.T + place.translation
            for place, (_, points) in zip(placed, self._shape_corners, strict=True)
        ]

    @cached_property
    def _shape_corners(self) -> list[tuple[int, Array]]:
        return [(shape.parentJoint, corners(shape)) for shape in self.geometry.geometryObjects]

    def limits(self, group: str) -> Limits:
        """Return the limits of a group's joints, in the group's order."""
        return self.limits_of(self.description.group(group))

    def limits_of(self, names: tuple[str, ...]) -> Limits:
        q = [self._columns[n] for n in names]
        jerks = np.array([self.description.jerk_limits.get(n, np.inf) for n in names])
        return Limits(
            self.model.lowerPositionLimit[q],
            self.model.upperPositionLimit[q],
            self.model.velocityLimit[q],
            np.array([self.description.acceleration_limits[n] for n in names]),
            jerks if np.isfinite(jerks).any() else None,
        )

    def chain(self, group: str, *states: JointState) -> Chain:
        """Return the chain of a group, with the other joints where `states` say (else at home, open).

        Chains are kept: a hand's posture changes far more seldom than plans are made. The others are to 1 mrad where
        `states` say, so that a chain doesn't depend on who asked for it first.
        """
        names, q = self._moved_and_rest([group], states)
        q = np.round(q, 3)
        key = (group, q.tobytes())
        if key not in self._chains:
            if len(self._chains) >= 16:
                self._chains.pop(next(iter(self._chains)))
            self._chains[key] = self._reduced(group, names, q)
        return self._chains[key]

    def joined_chain(self, groups: Sequence[str], *states: JointState) -> Chain:
        """Return the chain of several groups at once, with the other joints where `states` say.

        Its grasp frame is that of the first group. It isn't kept.
        """
        return self._reduced(groups[0], *self._moved_and_rest(groups, states))

    def _moved_and_rest(self, groups: Sequence[str], states: Sequence[JointState]) -> tuple[tuple[str, ...], Array]:
        """Return the joints of groups, from the base on as pin lists them, and where the others are."""
        q = self.configuration(*states)
        mine = {joint for group in groups for joint in self.description.group(group)}
        names = tuple(name for name in self._columns if name in mine)
        q[[self._columns[n] for n in names]] = 0.0
        return names, q

    def _reduced(self, group: str, names: tuple[str, ...], q: Array) -> Chain:
        frozen = [self.model.getJointId(n) for n in self.model.names if n not in (*names, "universe")]
        model, geometry = pin.buildReducedModel(self.model, self.geometry, frozen, q)
        shapes = geometry.geometryObjects  # what no joint moves apart tells nothing about a configuration
        _keep_pairs(
            geometry,
            [shapes[p.first].parentJoint != shapes[p.second].parentJoint for p in geometry.collisionPairs],
        )
        hands = frozenset(self.description.hand_links)
        return Chain(names, model, geometry, self.limits_of(names), hands, self.grasp_frame_of(group))

    def grasp_frame_of(self, group: str) -> str:
        """Return the name of the grasp frame of an arm's group; the robot's first one for a group without its own."""
        return self._frames.get(group, GRASP_FRAME)

    def _add_grasp_frames(self) -> dict[str, str]:
        """Add each grasp frame to the model; return the names of those that belong to one group."""
        own = {f"{GRASP_FRAME}/{group}": frame for group, frame in self.description.grasp_frames.items()}
        for name, frame in {GRASP_FRAME: self.description.grasp_frame, **own}.items():
            parent = self.model.getFrameId(frame.link, pin.FrameType.BODY)  # joints may be called so, too
            link = self.model.frames[parent]
            placement = link.placement * pin.SE3(frame.pose.matrix())
            self.model.addFrame(pin.Frame(name, link.parentJoint, parent, placement, pin.OP_FRAME))
        return {group: f"{GRASP_FRAME}/{group}" for group in self.description.grasp_frames}

    def _drop_harmless_pairs(self) -> None:
        """Keep the pairs of shapes that are worth checking.

        Left out are pairs of one link or of neighbours, pairs within one hand (closing is the fingers' own
        business), those that the vendor disabled, and those that overlap in nearly all of 300 random ones.
        """
        shapes = self.geometry.geometryObjects
        links = [link_of(self.model, s) for s in shapes]
        neighbours = _neighbours(self.model, set(links))
        hand_of = {link: hand for hand, mine in self.description.hands.items() for link in mine}
        for a, b in combinations(range(len(shapes)), 2):
            pair = tuple(sorted((links[a], links[b])))
            harmless = (
                links[a] == links[b]
                or pair in neighbours
                or pair in self.description.disabled_pairs
                or (links[a] in hand_of and hand_of[links[a]] == hand_of.get(links[b]))
            )
            if not harmless:
                self.geometry.addCollisionPair(pin.CollisionPair(a, b))
        overlaps = self._overlap_rates()
        _keep_pairs(self.geometry, overlaps <= _ALWAYS)

    def _overlap_rates(self) -> Array:
        rng = np.random.default_rng(0)
        hands = {j for hand in self.description.hands for j in self.description.groups.get(hand, ())}
        names = tuple(n for n in self.description.joints if n not in hands)
        columns, limits = [self._columns[n] for n in names], self.limits_of(names)
        data, counts = self.geometry.createData(), np.zeros(len(self.geometry.collisionPairs))
        q = np.array(self._rest)
        for _ in range(_SAMPLES):
            q[columns] = rng.uniform(limits.lower, limits.upper)
            pin.computeCollisions(self.model, self.data, self.geometry, data, q, False)
            counts += [result.isCollision() for result in data.collisionResults]
        return counts / _SAMPLES


def link_of(model: pin.Model, shape: pin.GeometryObject) -> str:
    """Return the name of the link that a collision shape belongs to."""
    return str(model.frames[shape.parentFrame].name)


def _keep_pairs(geometry: pin.GeometryModel, kept: Iterable[bool]) -> None:
    pairs = [pair for pair, keep in zip(geometry.collisionPairs, kept, strict=True) if keep]
    geometry.removeAllCollisionPairs()
    for pair in pairs:
        geometry.addCollisionPair(pair)


def _neighbours(model: pin.Model, links_with_shapes: set[str]) -> set[tuple[str, str]]:
    """Return the pairs of links that one joint connects; links without shapes count as part of the joint."""
    parents: Mapping[str, str] = {
        str(frame.name): _next_link_up(model, frame, links_with_shapes)
        for frame in model.frames
        if str(frame.name) in links_with_shapes
    }
    return {tuple(sorted(pair)) for pair in parents.items()}  # type: ignore[misc]


def _next_link_up(model: pin.Model, frame: pin.Frame, links: set[str]) -> str:
    while frame.parentFrame != 0:
        frame = model.frames[frame.parentFrame]
        if frame.type == pin.FrameType.BODY and str(frame.name) in links:
            return str(frame.name)
    return ""
