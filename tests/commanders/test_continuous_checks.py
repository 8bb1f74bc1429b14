"""A check of a hand's hull first, and of motions all along, says the same as a check of everything."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly
from table_top import robot_model

from grip_bt.base.values import Pose, Trajectory
from grip_bt.base.values.solids import Box, Cylinder
from grip_bt.commanders.kinematics.collision import _KEPT, CollisionChecker, _newest, checker_of
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.continuous import continuously_free, first_touch
from grip_bt.commanders.planning.paths import interpolated
from grip_bt.commanders.planning.search import halving
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot

SCENE = SceneSnapshot(
    {
        "table": SceneObject("table", Box((0.7, 1.2, 0.1)), Pose((0.65, 0.0, -0.05)), fixed=True),
        "tower": SceneObject("tower", Box((0.1, 0.1, 0.4)), Pose((0.5, 0.0, 0.2))),
        "can": SceneObject("can", Cylinder(0.05, 0.3), Pose((0.5, -0.35, 0.15))),
        "held": SceneObject("held", Box((0.06, 0.06, 0.2)), Pose((0.0, 0.0, 0.05)), hand="hand"),
    }
)


@pytest.fixture(scope="module")
def chain():
    return robot_model().chain("arm")


@pytest.fixture(scope="module")
def checker(chain):
    return CollisionChecker(chain, SCENE, "hand")


def random_rows(chain, count, seed):
    return np.random.default_rng(seed).uniform(chain.limits.lower, chain.limits.upper, (count, len(chain.joints)))


def everything_free(checker, q):
    """Ask pin about each pair, without hull or tree."""
    chain, data = checker.chain, checker._geometry.createData()
    touching = pin.computeCollisions(chain.model, chain.data, checker._geometry, data, q, True)
    assert touching == bool(checker.pairs(q))
    return not touching


def cpu_times():
    """CPU time of each of this process's threads [ns]."""
    return {task.name: int((task / "schedstat").read_text().split()[0]) for task in Path("/proc/self/task").iterdir()}


@pytest.mark.parametrize("cores", [1, 2])
def test_a_large_batch_is_shared_evenly_by_as_many_threads_as_there_are_cores(chain, monkeypatch, cores):
    """Told by how long each thread worked, since a loaded machine may give them one core in turns."""
    monkeypatch.setattr("grip_bt.commanders.kinematics.collision.os.cpu_count", lambda: cores)
    checker, rows = CollisionChecker(chain, SceneSnapshot()), random_rows(chain, 4000, seed=1)
    checker.free_each(rows[:100])  # threads are made when they are first needed
    before = cpu_times()
    checker.free_each(rows)
    worked = sorted((spent - before.get(task, 0) for task, spent in cpu_times().items()), reverse=True)
    shares = [time / sum(worked) for time in worked]
    assert shares[cores - 1] > 0.5 / cores
    assert sum(shares[:cores]) > 0.9


def test_the_hull_first_gives_the_same_answers_as_all_pairs(chain, checker):
    rows = random_rows(chain, 400, seed=0)
    free = checker.free_each(rows)
    assert 0.2 < free.mean() < 0.9
    assert free.tolist() == [everything_free(checker, q) for q in rows]
    assert [checker.free(q) for q in rows[:40]] == free[:40].tolist()


@pytest.mark.parametrize("seed", range(3))
def test_all_are_free_when_each_one_is_in_whatever_order_they_are_asked(chain, checker, seed):
    rng = np.random.default_rng(seed)
    rows = random_rows(chain, 3000, seed)
    free = checker.free_each(rows)
    hulls = checker._ask(checker._rough, rows, stop_at_first=False)
    harmless = rows[free & hulls]  # free, though the hand's hull touches something
    assert len(harmless)
    good = np.concatenate([rows[free][:60], harmless])
    assert checker.all_free(rng.permutation(good))
    assert checker.all_free(good[:1])
    assert checker.all_free(good[:0])
    for count in (1, 3, 25, 60, 90):
        some = rng.permutation(np.concatenate([good[:count], rows[~free][:1]]))
        assert not checker.all_free(some)
        assert not checker.all_free(some[::-1])


@given(st.integers(1, 3000))
def test_halving_names_every_step_once_and_the_end_first(steps):
    order = np.round(halving(steps) * steps).astype(int)
    assert order[0] == steps
    assert sorted(order) == list(range(1, steps + 1))
    for count in (1, 3, 7, 15, 31):
        seen = np.sort(np.concatenate([[0], order[: count + 1]]))
        assert np.diff(seen).max() <= 2 * (steps // (count + 1) + 1)


def test_what_is_clear_by_a_margin_is_that_far_apart(chain, checker):
    rows = random_rows(chain, 300, seed=1)
    geometry, data = checker._geometry, checker._geometry.createData()
    for margin in (0.01, 0.05):
        clear = checker.clear_each(rows, margin)
        assert clear.any()
        for q in rows[clear][:25]:
            pin.computeDistances(chain.model, chain.data, geometry, data, q)
            assert min(result.min_distance for result in data.distanceResults) >= margin - 1e-6


def test_asking_for_a_margin_leaves_plain_checks_as_they_were(chain, checker):
    rows = random_rows(chain, 200, seed=2)
    before = checker.free_each(rows)
    checker.clear_each(rows, 0.1)
    assert checker.free_each(rows).tolist() == before.tolist()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6))
def test_nothing_moves_further_than_the_bound_says(seed):
    chain = robot_model().chain("arm")
    checker = CollisionChecker(chain, SCENE, "hand")
    one, other = random_rows(chain, 2, seed)
    pair = np.stack([one, one + 0.2 * (other - one)])
    bound = float(np.abs(pair[1] - pair[0]) @ checker.reaches)
    geometry, data = checker._geometry, checker._geometry.createData()
    places = []
    for q in pair:
        pin.updateGeometryPlacements(chain.model, chain.data, geometry, data, q)
        corners = [data.oMg[k].act(corner) for k, corner in _corners(geometry)]
        places.append(np.array(corners))
    assert np.linalg.norm(places[1] - places[0], axis=1).max() <= bound + 1e-9


def test_where_joints_may_move_nothing_touches_after_any_such_motion(chain, checker):
    rng, rows = np.random.default_rng(4), random_rows(chain, 400, seed=4)
    motion = np.array([0.002, 0.004, 0.002, 0.006, 0.02, 0.04, 0.06])
    clear = checker.clear_while_moving(rows, motion)
    nowhere = checker.clear_each(rows, float(motion @ checker.reaches))
    assert clear.sum() > nowhere.sum() > 0  # pairs of links know which joints are between them
    assert clear[nowhere].all()
    for q in rows[clear][:40]:
        moved = q + motion * rng.choice([-1.0, 1.0], (20, len(motion)))
        assert all(everything_free(checker, other) for other in moved)


def _corners(geometry):
    for k, shape in enumerate(geometry.geometryObjects):
        shape.geometry.computeLocalAABB()
        box = shape.geometry.aabb_local
        yield k, box.min_
        yield k, box.max_


def test_a_motion_is_free_all_along_only_if_its_fine_samples_are(chain, checker):
    rows, answers = random_rows(chain, 160, seed=3), []
    for one, other in zip(rows[::2], rows[1::2], strict=True):
        motion = interpolated(np.stack([one, one + 0.4 * (other - one)]), 0.05)
        fine = checker.free_each(interpolated(motion, 0.004)).all()
        # Stricter is allowed where samples miss a graze; the other way round never.
        answers.append((continuously_free(checker, motion), bool(fine)))
    assert (True, False) not in answers
    assert answers.count((True, True)) > 10
    assert answers.count((False, True)) == 0


def random_part(chain, columns, middle, rng):
    """A trajectory of some of the joints, of points with velocities, with accelerations too, or without either."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.6, rng.integers(1, 6)))])
    size = (len(times), len(columns))
    derivatives = [rng.normal(0.0, spread, size) for spread in (0.5, 2.0)][: rng.integers(0, 3)]
    rows = middle[columns] + np.cumsum(rng.normal(0.0, 0.08, size), axis=0)
    return Trajectory(tuple(chain.joints[k] for k in columns), times, rows, *derivatives)


def between_points(trajectory, times):
    """Where a controller has the joints, as scipy draws it: shape (m, n)."""
    given = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    values = np.stack([rows for rows in given if rows is not None], axis=1)
    return BPoly.from_derivatives(trajectory.times, values)(np.clip(times, 0.0, trajectory.duration))


def test_trajectories_at_once_are_free_only_if_all_that_controllers_draw_between_their_points_is(chain, checker):
    rng, answers, touched = np.random.default_rng(5), [], 0
    for _ in range(120):
        order, cut, middle = rng.permutation(7), rng.integers(1, 7), random_rows(chain, 1, rng.integers(10**6))[0]
        parts = [random_part(chain, columns, middle, rng) for columns in (order[:cut], order[cut:])]
        times = np.arange(0.0, max(part.duration for part in parts), 0.002)
        rows = np.zeros((len(times), 7))
        for part in parts:
            rows[:, [chain.joints.index(name) for name in part.names]] = between_points(part, times)
        found, fine = first_touch(checker, *parts), checker.free_each(rows)
        answers.append((found is None, bool(fine.all())))
        if found is not None and found[1]:
            at = np.array([found[0]])
            row = np.zeros(7)
            for part in parts:
                row[[chain.joints.index(name) for name in part.names]] = between_points(part, at)[0]
            assert set(checker.pairs(row)) == set(found[1])
            touched += 1
    # Stricter is allowed where samples miss a graze; the other way round never.
    assert (True, False) not in answers
    assert answers.count((True, True)) > 10
    assert answers.count((False, True)) <= 2
    assert touched > 10


@pytest.mark.parametrize("seed", range(3))
def test_a_checker_that_was_asked_before_answers_as_a_new_one(chain, seed):
    """The same scene in another object is the same scene, as a planner gets it with each request."""
    kept, moved = checker_of(chain, SCENE, "hand"), np.full(len(chain.joints), 0.05)
    for rows in (random_rows(chain, 200, 100 + seed), random_rows(chain, 30, 200 + seed)):
        again = checker_of(chain, SceneSnapshot(dict(SCENE.objects)), "hand")
        new = CollisionChecker(chain, SCENE, "hand")
        assert again is kept
        assert (again.free_each(rows) == new.free_each(rows)).all()
        assert (again.clear_while_moving(rows, moved) == new.clear_while_moving(rows, moved)).all()
        assert (again.clear_while_moving(rows, moved, False) == new.clear_while_moving(rows, moved, False)).all()
        assert [again.pairs(q) for q in rows[:30]] == [new.pairs(q) for q in rows[:30]]
        assert again.all_free(rows) == new.all_free(rows)


def test_a_checker_is_kept_for_what_it_was_made_of_alone(chain):
    other = RobotModel(robot_model().description).chain("arm")
    moved = SCENE.with_object(replace(SCENE.objects["can"], pose=Pose((0.5, -0.3, 0.15))))
    turned = SceneSnapshot(dict(reversed(SCENE.objects.items())))
    made_of = [(chain, SCENE, "hand"), (chain, SCENE, "hand", 0.01), (chain, SCENE), (chain, moved, "hand")]
    made_of += [(chain, turned, "hand"), (other, SCENE, "hand"), (chain, SCENE.without(["can"]), "hand")]
    made = [checker_of(*each) for each in made_of]
    assert len(set(map(id, made))) == len(made)
    for k in range(_KEPT):
        checker_of(chain, SCENE.with_object(replace(SCENE.objects["can"], pose=Pose((0.5, 0.01 * k, 0.15)))), "hand")
    assert len(_newest) == _KEPT
    assert checker_of(*made_of[0]) is not made[0]
