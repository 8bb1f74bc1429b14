"""Whatever leaves a commander is within the limits, and free, on what controllers draw between its points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motion_kinds import ARMS, PERIOD, Motions, drawn, kinds, many, used
from table_top import robot_model

from grip_bt.base.failures import OutOfLimitsError, PathInvalidError
from grip_bt.base.values import JointState, WayPoint
from grip_bt.commanders.planning.requests import PlanStraight, PlanThrough, PlanTo
from grip_bt.commanders.trajectory.limits import Limits
from grip_bt.commanders.trajectory.splines import eased, peaks, slowed
from grip_bt.commanders.trajectory.timing import STILL, timed

ROUNDED = 1 + 1e-6


@pytest.fixture(scope="module", params=[*ARMS.items(), ("panda", "arm")], ids=lambda arm: arm[0])
def motions(request):
    name, group = request.param
    if name not in ARMS:
        group = next(g for g, joints in robot_model(name).description.groups.items() if len(joints) == 7)
    return Motions(name, group)


@pytest.mark.parametrize("kind", kinds())
def test_velocities_and_accelerations_at_1_khz_are_within_their_limits(motions, kind):
    found = list(many(motions, kind, 5))
    assert found
    for trajectory in found:
        for what, part in used(motions, trajectory):
            assert part <= ROUNDED, what


@pytest.mark.parametrize("kind", kinds())
def test_no_sample_at_1_khz_touches_anything(kind):
    motions = Motions("panda_allegro", "arm")
    for trajectory in many(motions, kind, 4):
        if len(trajectory.times) > 1:
            rows = drawn(trajectory, quintic=False)(np.arange(0.0, trajectory.duration, PERIOD))
            assert motions.checker.free_each(rows).all()


@pytest.mark.parametrize("jerk", [20.0, 200.0])
@pytest.mark.parametrize("kind", [kind for kind in kinds() if not kind.startswith("given")])
def test_jerks_at_1_khz_are_within_their_limits_where_that_is_asked(kind, jerk):
    motions = Motions("panda_allegro", "arm", jerk=jerk)
    found = list(many(motions, kind, 3))
    assert found
    for trajectory in found:
        way = "cubic" if trajectory.accelerations is None else "quintic"
        parts = {what: part for what, part in used(motions, trajectory) if what.startswith(way)}
        assert f"{way} jerk" in parts or len(trajectory.times) == 1
        assert max(parts.values(), default=0.0) <= ROUNDED, parts


# --- being almost where one is asked to be ---


@pytest.fixture(scope="module")
def gripper():
    return Motions("panda", next(g for g, js in robot_model("panda").description.groups.items() if len(js) == 7))


FAR = st.one_of(st.just(0.0), st.floats(-8, 0).map(lambda power: 10.0**power))
"""Distances from nothing to 1 rad, the tiny ones as likely as the large ones."""


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), FAR, FAR, st.booleans())
def test_any_start_goal_and_noise_gives_a_motion_or_an_instant_success(gripper, seed, far, noise, one_joint):
    rng = np.random.default_rng(seed)
    begin = gripper.free(rng)
    way = rng.normal(size=7) * (np.arange(7) == seed % 7 if one_joint else 1)
    limits = gripper.chain.limits
    goal = np.clip(begin + far * way / np.abs(way).max(), limits.lower, limits.upper)
    if not gripper.checker.free(goal):
        return
    measured = np.clip(begin + noise * 1e-3 * rng.normal(size=7), limits.lower, limits.upper)
    if not gripper.checker.free(measured):
        return
    at, end = gripper.at(measured), gripper.goal(goal)
    middle = gripper.goal((measured + goal) / 2)
    asked = {
        "free": PlanTo(at, end),
        "twice the same": PlanThrough(at, (WayPoint(end, radius=0.05), WayPoint(end, radius=0.05), WayPoint(end))),
        "there and back": PlanThrough(at, (WayPoint(middle, radius=0.02), WayPoint(end), WayPoint(middle))),
    }
    for what, request in asked.items():
        try:
            trajectory = gripper.answer(request)
        except PathInvalidError as error:
            if what == "free" or not error.data.get("pairs"):
                raise
            continue  # a straight way through something
        last = (measured + goal) / 2 if what == "there and back" else goal
        assert trajectory.positions[-1] == pytest.approx(last, abs=STILL), what
        assert all(part <= ROUNDED for _, part in used(gripper, trajectory))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), FAR, FAR)
def test_so_do_lines_of_any_length_and_turns_of_any_angle(gripper, seed, far, turn):
    rng = np.random.default_rng(seed)
    begin = gripper.free(rng, 0.3)
    pose = gripper.pose(begin)
    axis = rng.normal(size=3)
    half = min(turn, 0.5) / 2
    spin = type(pose)(quaternion=[np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis))])
    goal = pose.moved(0.1 * far * rng.uniform(-1, 1, 3)) @ spin
    try:
        trajectory = gripper.answer(PlanStraight(gripper.at(begin), (goal, goal)))
    except (PathInvalidError, OutOfLimitsError):
        return
    reached = gripper.pose(trajectory.positions[-1])
    assert reached.position == pytest.approx(goal.position, abs=2e-4)
    assert all(part <= ROUNDED for _, part in used(gripper, trajectory))


# --- the timing by itself ---


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(2, 12), FAR, st.none() | st.floats(1, 1000))
def test_any_path_is_timed_within_its_limits(seed, joints, corners, size, jerk):
    rng = np.random.default_rng(seed)
    steps = rng.uniform(-1, 1, (corners, joints)) * 10.0 ** rng.uniform(-6, 0, (corners, 1)) * size
    steps[rng.random(corners) < 0.2] = 0.0  # the same row twice
    steps[1:][rng.random(corners - 1) < 0.2] *= 0.0
    path = np.cumsum(steps, axis=0)
    if rng.random() < 0.3:
        path = np.concatenate([path, path[::-1]])
    velocity, acceleration = rng.uniform(0.2, 3, joints), rng.uniform(0.2, 15, joints)
    sharpest = None if jerk is None else acceleration * jerk
    limits = Limits(np.full(joints, -99.0), np.full(joints, 99.0), velocity, acceleration, sharpest)
    names = tuple(f"joint_{k}" for k in range(joints))
    trajectory = timed(names, path, limits, lambda _: True)
    assert trajectory.positions[0] == pytest.approx(path[0], abs=STILL)
    assert trajectory.positions[-1] == pytest.approx(path[-1], abs=STILL)
    most = peaks(trajectory)
    for found, limit in zip(most, (velocity, acceleration, sharpest), strict=True):
        assert limit is None or (found <= limit * ROUNDED).all()
    if trajectory.duration:
        assert not trajectory.velocities[[0, -1]].any()
        assert np.abs(trajectory.accelerations[[0, -1]]).max() <= 1e-6 * acceleration.max()


def test_peaks_are_those_of_the_cubics_that_scipy_draws():
    motions = Motions("panda_allegro", "arm")
    for trajectory in many(motions, "free", 3):
        times = np.linspace(0.0, trajectory.duration, 20001)
        for order, found in enumerate(peaks(trajectory), 1):
            sampled = np.abs(drawn(trajectory, False, order)(times)).max(axis=0)
            assert (sampled <= found * ROUNDED).all()
            assert sampled == pytest.approx(found, rel=1e-2 if order < 3 else 0.2)


def test_an_instant_success_is_one_point(gripper):
    here = gripper.free(np.random.default_rng(1))
    trajectory = gripper.answer(PlanTo(gripper.at(here), JointState(gripper.chain.joints, here)))
    assert trajectory.duration == 0.0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), FAR, st.floats(0.05, 3))
def test_fingers_move_from_rest_to_rest_within_what_they_can_and_no_sooner_than_asked(seed, far, seconds):
    rng = np.random.default_rng(seed)
    start, way = rng.uniform(-1, 1, (2, 4))
    velocity, acceleration = rng.uniform(0.5, 3, 4), rng.uniform(1, 40, 4)
    moved = slowed(eased(("a", "b", "c", "d"), start, start + far * way, seconds), velocity, acceleration)
    assert moved.duration >= seconds * (1 - 1e-9)
    assert moved.positions[-1] == pytest.approx(start + far * way, abs=1e-12)
    fastest, hardest, _ = peaks(moved)
    assert (fastest <= velocity * ROUNDED).all()
    assert (hardest <= acceleration * ROUNDED).all()
