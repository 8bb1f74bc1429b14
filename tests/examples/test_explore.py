"""The exploring example: where it looks from, what it keeps, its registration, its grasps, and that the task holds."""

import importlib.util
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import MockStep, scripted
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.nodes.node import Observer

EXPLORE = Path(__file__).parents[2] / "examples" / "explore"
RNG = np.random.default_rng(5)


def loaded(name):
    file = EXPLORE / name
    spec = importlib.util.spec_from_file_location(f"{file.stem}_under_test", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


exploring, gripping = loaded("nodes/exploring.py"), loaded("nodes/gripping.py")
angle = st.floats(0.3, 1.5)


@settings(max_examples=30, deadline=None)
@given(st.integers(2, 20), st.floats(0, 4), st.floats(0.2, 1.0), angle, angle)
def test_every_camera_of_the_spiral_looks_at_the_middle_from_its_distance(views, turns, distance, steepest, flattest):
    centre = np.array([0.5, -0.1, 0.02])
    way = exploring.looking(centre, views, turns, distance, steepest, flattest)
    assert len(way) == views
    for pose in way:
        np.testing.assert_allclose(pose.apply([[0, 0, distance]])[0], centre, atol=1e-9)
        assert pose.rotation()[0, 1] <= 1e-9  # the image's down isn't +x


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.002, 0.05))
def test_thinned_points_are_the_means_of_their_cells(seed, cell):
    points = np.random.default_rng(seed).uniform(-0.1, 0.1, (300, 3))
    found = exploring.thinned(points, cell)
    keys = {tuple(key) for key in np.floor(points / cell).astype(int)}
    assert len(found) == len(keys)
    away = np.linalg.norm(found[:, None] - points[None], axis=2).min(axis=1)
    assert away.max() <= cell * np.sqrt(3)


def box(size, at, step=0.0045):
    """Points of the surface of an upright box that stands on z = 0, without its underside."""
    x, y, z = size
    flat = [np.stack(np.meshgrid(*(np.arange(-e / 2, e / 2 + 1e-9, step) for e in (a, b))), -1).reshape(-1, 2)
            for a, b in ((x, y), (x, z), (y, z))]  # fmt: skip
    top = np.column_stack([flat[0], np.full(len(flat[0]), z)])
    sides = [np.column_stack([flat[1][:, 0], np.full(len(flat[1]), s * y / 2), flat[1][:, 1] + z / 2]) for s in (1, -1)]
    sides += [
        np.column_stack([np.full(len(flat[2]), s * x / 2), flat[2][:, 0], flat[2][:, 1] + z / 2]) for s in (1, -1)
    ]
    return np.vstack([top, *sides]) + [*at, 0.0]


def test_a_box_is_taken_across_its_faces_and_not_where_something_stands_beside_it():
    thing = box((0.04, 0.06, 0.05), (0.5, 0.0))
    alone = gripping.candidates(thing, gap=0.08, depth=0.045)
    assert alone
    _, frame, place, width = max(alone, key=lambda each: each[0])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-9)
    assert np.abs(frame[0, :2]).max() > 0.9  # it closes across faces, not corners
    assert min(abs(width - 0.04), abs(width - 0.06)) < 0.012
    assert np.linalg.norm(place[:2] - [0.5, 0.0]) < 0.03
    walls = np.vstack([thing, *(box((0.01, 0.1, 0.08), (0.5 + s * 0.04, 0.0)) for s in (1, -1))])
    for _, frame, place, _ in gripping.candidates(walls, gap=0.08, depth=0.045):
        if np.linalg.norm(place[:2] - [0.5, 0.0]) < 0.02 and frame[2, 2] < -0.99:
            assert abs(frame[0, 0]) < 0.5, "a finger would be in the wall"


def test_where_nothing_is_there_is_no_grasp_and_nothing_is_taken_that_is_too_wide():
    assert gripping.candidates(np.zeros((0, 3)), 0.08, 0.045) == []
    assert all(
        each[3] < 0.08 - 2 * gripping.ROOM
        for each in gripping.candidates(box((0.12, 0.12, 0.04), (0.5, 0.0)), 0.08, 0.045)
    )


@pytest.fixture(scope="module")
def registration():
    pytest.importorskip("small_gicp")
    return loaded("components/registration/registration.py")


def scene():
    table = np.column_stack([RNG.uniform(-0.2, 0.2, (12000, 2)), np.zeros(12000)])
    things = [
        box((0.05, 0.06, 0.05), (0.06, 0.05)),
        box((0.03, 0.09, 0.04), (-0.08, 0.02)),
        box((0.1, 0.03, 0.03), (0, -0.1)),
    ]
    whole = np.vstack([table, *things])
    return whole[RNG.random(len(whole)) < 0.7] + RNG.normal(0, 0.0007, (1, 3))


def test_registration_undoes_what_kinematics_are_wrong_by_and_stays_where_they_are_on_average(registration):
    off = [Pose(RNG.normal(0, 0.004, 3), quaternion_of(*RNG.normal(0, 0.01, 3))) for _ in range(5)]
    clouds = [pose.apply(scene()) for pose in off]
    moved, residual = registration.register(clouds, 0.004, 0.02)
    points = np.array([[0.1, 0.1, 0.05], [-0.1, 0.1, 0.0], [0.0, -0.1, 0.05]])

    def between(poses):
        ends = np.array([registration.applied(pose, points) for pose in poses])
        return np.sqrt(((ends - ends.mean(axis=0)) ** 2).sum(axis=2).mean())

    before, after = (
        between([pose.matrix() for pose in off]),
        between([m @ o.matrix() for m, o in zip(moved, off, strict=True)]),
    )
    assert after < before / 3
    assert residual < 0.003
    shift = np.mean(
        [registration.applied(m, c) - c for m, c in zip(moved, clouds, strict=True) for c in [c[:2000]]], axis=(0, 1)
    )
    assert np.linalg.norm(shift) < 0.001


@settings(max_examples=20, deadline=None)
@given(st.floats(-0.01, 0.01), st.floats(-0.03, 0.03), st.floats(-0.03, 0.03))
def test_a_table_is_put_at_its_height_whatever_stands_on_it(registration, high, roll, pitch):
    points = Pose((0.0, 0.0, high), quaternion_of(roll, pitch, 0.0)).apply(scene())
    levelled = registration.applied(registration.levelled(points, 0.0), points)
    table = levelled[: int(0.5 * len(levelled))]
    assert np.abs(table[:, 2]).max() < 0.003


class Ends(Observer):
    def __init__(self):
        self.seen = Counter()

    def ended(self, path, outcome, failure):
        self.seen[path.removeprefix("attempt/"), outcome] += 1


@pytest.mark.parametrize("form", ["bt", "sm"])
@pytest.mark.parametrize("views", ["registered", "kinematics", "fixed"])
def test_the_task_goes_round_merges_as_it_is_told_and_tries_a_second_time(views, form, tmp_path):
    place = {"position": [0.5, 0.0, 0.3]}
    mocks = scripted(
        {
            "attempt/explore/keep_it": "success",
            "attempt/explore/around/spiral/plan_way": [MockStep(outcome="success", outputs={"way": [place] * 3})],
            "attempt/explore/around/spiral/follow/see/view/go": "success,failure.no_ik,success",
            "attempt/explore/around/spiral/follow/see/view/keep": "success",
            "attempt/merge/register/registration": [MockStep(outcome="registered", outputs={"corrections": []})],
            "attempt/merge/join": "success",
            "attempt/propose": "success",
            "attempt/choose": "success",
            "attempt/pick/take": "failure.no_contact,success",
            "attempt/check": "success",
        }
    )
    options = RunOptions(
        target=form, robot="fake", data={"views": views}, mocks=mocks, journal=tmp_path / "runs.sqlite"
    )
    ends = Ends()
    with open_session(EXPLORE / "tasks" / "explore.yaml", options) as session:
        session.runner.observe(ends)
        result = session.runner.run()
    assert result.outcome == "taken", result
    assert ends.seen["pick/back/retreat", "success"] == ends.seen["check", "success"] == 1
    merged = {True: "merge/join", False: "merge/register/registration"}[views == "kinematics"]
    assert sum(n for (path, _), n in ends.seen.items() if path == merged) == 2
    looks = ends.seen["explore/around/spiral/follow/see/view/look", "success"]
    assert looks == (0 if views == "fixed" else 5)
