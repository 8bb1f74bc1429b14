"""Motions of every kind that leaves a commander, at random, and what they take of the joints' limits.

What a controller draws between the points is scipy's here, from values and derivatives, not the project's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.interpolate import BPoly
from table_top import PATIENCE, robot_model, room

from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import JointState, Trajectory, WayPoint
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.pausing import rest_of
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import (
    CheckTrajectory,
    PlanServoStep,
    PlanStraight,
    PlanThrough,
    PlanTo,
    Request,
    Situation,
)
from grip_bt.commanders.scene_state import SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.commanders.steering import HOLD, jogged, spliced
from grip_bt.commanders.trajectory.stopping import stop_ramp

PERIOD = 1e-3
"""Controllers take their set points at this period [s]."""
ARMS = {"panda_allegro": "arm", "ur10_allegro": "arm", "two_ur5_allegro": "arms"}
"""Robot -> group of an arm, or of both arms."""


class Motions:
    """Random motions of one group, the same ones for the same seed.

    Args:
        robot: name of a ready-made one.
        group: of its joints.
        speed: part of the velocity and acceleration limits.
        jerk: limit of each joint's jerk over that of its acceleration [1/s]; None: any jerk.
    """

    def __init__(self, robot: str, group: str, speed: float = 1.0, jerk: float | None = None):
        self.model, self.group = robot_model(robot), group
        rest = JointState.from_mapping(self.model.description.at_rest)
        self.scene = room(self.model).snapshot() if robot == "panda_allegro" else SceneSnapshot()
        self.hand = "right_hand" if robot == "panda_allegro" else ""
        self.chain = self.model.chain(group, rest)
        if jerk is not None:
            limits = self.chain.limits
            self.chain.limits = replace(limits, jerk=limits.acceleration * jerk)
        self.checker = CollisionChecker(self.chain, self.scene, self.hand)
        self._rest, self._settings = rest, PlanningSettings(speed=speed, planning_time=PATIENCE, jerk=jerk and 1.0)
        used = self.chain.limits
        self.velocity, self.acceleration, self.jerk = used.velocity * speed, used.acceleration * speed, used.jerk

    def of(self, kind: str, seed: int) -> Trajectory | None:
        """Return a motion of a kind in `kinds`; None where none is possible."""
        try:
            return kinds()[kind](self, np.random.default_rng(seed))
        except ExpectedError:
            return None

    def answer(self, request: Request) -> Trajectory:
        """Return the trajectory of an answered request."""
        return answer(self.model, request, lambda: False).trajectory

    def free(self, rng: np.random.Generator, spread: float = 1.0, about: np.ndarray | None = None) -> np.ndarray:
        """Return a free configuration, no joint of which is further than `spread` [rad] from another one."""
        limits = self.chain.limits
        middle = self._rest.ordered(self.chain.joints) if about is None else about
        for _ in range(1000):
            q = np.clip(middle + rng.uniform(-spread, spread, len(middle)), limits.lower, limits.upper)
            if self.checker.free(q):
                return q
        raise AssertionError("nothing is free there")

    def at(self, q: np.ndarray, velocity: np.ndarray | None = None, seed: int = 0) -> Situation:
        """Return the situation with the group's joints at `q`."""
        known = self._rest.as_mapping() | dict(zip(self.chain.joints, q.tolist(), strict=True))
        start = JointState.from_mapping(known)
        if velocity is not None:
            moving = dict(zip(self.chain.joints, velocity.tolist(), strict=True))
            start = replace(start, velocity=[moving.get(name, 0.0) for name in start.names])
        return Situation(self.group, start, self.scene, self.hand, self._settings.model_copy(update={"seed": seed}))

    def goal(self, q: np.ndarray) -> JointState:
        """Return positions of the group's joints as a state."""
        return JointState(self.chain.joints, q)

    def pose(self, q: np.ndarray):
        """Return the pose of the grasp frame."""
        return self.model.grasp_pose(self.at(q).start, group=self.group)


def kinds() -> dict[str, Callable[[Motions, np.random.Generator], Trajectory]]:
    """Return the kinds of motion: name -> what makes one."""
    return {
        "free": _free,
        "free, nearly there": _nearly_there,
        "straight (approach, lift, retreat)": _straight,
        "jog for a while": _jog,
        "through way points, blended": _blended,
        "through way points, searched": _searched,
        "given without velocities": _given,
        "steered (follow, jog without end)": _steered,
        "stop ramp": _stopped,
        "stop ramp of any motion": lambda motions, rng: _stopped(motions, rng, _any(motions, rng)),
        "gone on with after a pause": _gone_on,
        "gone on with, any motion": lambda motions, rng: _gone_on(motions, rng, _any(motions, rng)),
    }


def _free(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin, end = motions.free(rng), motions.free(rng)
    return motions.answer(PlanTo(motions.at(begin, seed=int(rng.integers(100))), motions.goal(end)))


def _nearly_there(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin = motions.free(rng)
    end = motions.free(rng, 10 ** rng.uniform(-7, -1), begin)
    return motions.answer(PlanTo(motions.at(begin), motions.goal(end)))


def _straight(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin = motions.free(rng, 0.3)
    return motions.answer(PlanStraight(motions.at(begin), (motions.pose(begin).moved(rng.uniform(-0.1, 0.1, 3)),)))


def _jog(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin = motions.free(rng, 0.3)
    linear, angular, seconds = rng.uniform(-0.2, 0.2, 3), rng.uniform(-0.5, 0.5, 3), rng.uniform(0.1, 1)
    to = jogged(motions.pose(begin), linear, angular, seconds)
    plan = answer(motions.model, PlanStraight(motions.at(begin), (to,)), lambda: False)
    return plan.trajectory.stretched(seconds)


def _blended(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin, points = motions.free(rng, 0.3), []
    pose = motions.pose(begin)
    for _ in range(3):
        pose = pose.moved(rng.uniform(-0.1, 0.1, 3))
        points.append(WayPoint(pose, radius=rng.uniform(0.005, 0.06)))
    return motions.answer(PlanThrough(motions.at(begin), (*points[:-1], replace(points[-1], radius=0.0))))


def _searched(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin, first, second = (motions.free(rng, 0.6) for _ in range(3))
    points = (WayPoint(motions.goal(first), radius=0.1, straight=False), WayPoint(motions.goal(second), straight=False))
    return motions.answer(PlanThrough(motions.at(begin), points))


def _given(motions: Motions, rng: np.random.Generator) -> Trajectory:
    begin = motions.free(rng, 0.6)
    rows = np.stack([begin, *(motions.free(rng, 0.6) for _ in range(3))])
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(1.0, 5.0, 3))])
    return motions.answer(CheckTrajectory(motions.at(begin), Trajectory(motions.chain.joints, times, rows)))


def _steered(motions: Motions, rng: np.random.Generator) -> Trajectory:
    """Go on step by step, with twists that change at random, until one isn't possible."""
    q, whole, began = motions.free(rng, 0.3), None, 0.0
    velocity = np.zeros_like(q)
    for k in range(8):
        linear, angular = rng.uniform(-0.25, 0.25, 3), rng.uniform(-0.5, 0.5, 3)
        request = PlanServoStep(motions.at(q, velocity), tuple(linear), tuple(angular), HOLD)
        try:
            step = motions.answer(request)
        except ExpectedError:
            if whole is None:
                raise
            break
        whole = step if whole is None else spliced(whole, step, began)
        began = (k + 1) * HOLD
        q, velocity, _ = (rows[0] for rows in whole.sampled(np.array([began])))
    return whole


def _any(motions: Motions, rng: np.random.Generator) -> Trajectory:
    """A motion that may be stopped or held: planned, steered, or gone on with after it was."""
    makers = (_straight, _jog, _blended, _searched, _steered, _gone_on)
    return makers[rng.integers(len(makers))](motions, rng)


def _stopped(motions: Motions, rng: np.random.Generator, whole: Trajectory | None = None) -> Trajectory:
    whole = whole or _free(motions, rng)
    return stop_ramp(whole, rng.uniform(0.0, whole.duration), motions.acceleration, motions.jerk)


def _gone_on(motions: Motions, rng: np.random.Generator, whole: Trajectory | None = None) -> Trajectory:
    whole = whole or _free(motions, rng)
    passed = rng.uniform(0.0, whole.duration)
    measured = whole.at(passed) + rng.uniform(-0.002, 0.002, len(whole.names))
    return rest_of(whole, measured, passed, motions.acceleration, motions.jerk)


def drawn(trajectory: Trajectory, quintic: bool, order: int = 0) -> Callable[[np.ndarray], np.ndarray]:
    """Return what a joint_trajectory_controller draws between the points, or a derivative of it: times -> (m, n)."""
    values = [trajectory.positions, trajectory.velocities]
    if quintic:
        values.append(trajectory.accelerations)
    return BPoly.from_derivatives(trajectory.times, np.stack(values, axis=1)).derivative(order)


def used(motions: Motions, trajectory: Trajectory) -> Iterator[tuple[str, float]]:
    """Yield what is used, such as `cubic velocity`, and which part of its limit: the most at 1 kHz of any joint."""
    if len(trajectory.times) < 2:
        return
    times = np.arange(0.0, trajectory.duration, PERIOD)
    for way, quintic in (("cubic", False), ("quintic", True)):
        if quintic and trajectory.accelerations is None:
            continue
        limits = {"velocity": motions.velocity, "acceleration": motions.acceleration, "jerk": motions.jerk}
        for order, (name, limit) in enumerate(limits.items(), 1):
            if limit is not None:
                found = np.abs(drawn(trajectory, quintic, order)(times)) / limit
                yield f"{way} {name}", float(found.max())
        if motions.jerk is not None and quintic is (trajectory.accelerations is not None):  # a jump has no derivative
            jumps = np.abs(np.diff(drawn(trajectory, quintic, 2)(times), axis=0)) / (PERIOD * motions.jerk)
            yield f"{way} jerk", float(jumps.max(initial=0.0))


def many(motions: Motions, kind: str, count: int) -> Iterator[Trajectory]:
    """Yield motions of a kind, of so many seeds; those that aren't possible are left out."""
    yield from filter(None, map(partial(motions.of, kind), range(count)))
