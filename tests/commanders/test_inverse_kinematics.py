"""What every solver promises, then what each one promises beyond it."""

import numpy as np
import pinocchio as pin
import pytest
from ik_search import nearest, solve
from table_top import named, robot_model

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.ports import FREEDOMS
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.damped_least_squares import TOLERANCE, Target, solve_from
from grip_bt.commanders.kinematics.ik import SOLVERS, solver
from grip_bt.commanders.kinematics.model import RobotModel

FITS = [(name, robot) for name in SOLVERS for robot in ("panda_allegro", "ur10_allegro")]


@pytest.fixture(scope="module")
def chains():
    ur10 = RobotModel(build_robot("ur10_allegro"))
    return {"panda_allegro": robot_model().chain("arm"), "ur10_allegro": ur10.chain("arm")}


@pytest.fixture
def chain(chains):
    return chains["panda_allegro"]


def configurations(chain, count, seed=1):
    return np.random.default_rng(seed).uniform(chain.limits.lower, chain.limits.upper, (count, len(chain.joints)))


@pytest.mark.parametrize(("name", "robot"), FITS)
class TestEverySolver:
    def test_reachable_poses_are_reached_to_the_tolerance_and_within_the_limits(self, chains, name, robot):
        chain, rng, solved = chains[robot], np.random.default_rng(0), 0
        for wanted, seed in zip(configurations(chain, 60), configurations(chain, 60, seed=2), strict=True):
            target = Target(chain.grasp_pose(wanted))
            q = solve(chain, target, rng, (seed,), restarts=40, kinematics=name)
            solved += q is not None
            assert q is None or (chain.within_limits(q) and target.distance(chain, q) < TOLERANCE)
        assert solved == 60

    @pytest.mark.parametrize("free", FREEDOMS)
    def test_partial_targets_are_reached_and_leave_the_rest_free(self, chains, name, robot, free):
        chain = chains[robot]
        pose = chain.grasp_pose(configurations(chain, 1, seed=5)[0])
        q = solve(chain, Target(pose, free), np.random.default_rng(0), restarts=40, kinematics=name)
        reached = chain.grasp_pose(q)
        assert reached.translation == pytest.approx(pose.translation, abs=1.1e-4)
        kept = {"none": "xyz", "orientation": ""}.get(free, free)
        for axis in kept:
            k = "xyz".index(axis)
            assert reached.rotation[:, k] == pytest.approx(pose.rotation[:, k], abs=1.5e-4)

    def test_solutions_are_distinct(self, chains, name, robot):
        chain = chains[robot]
        target = Target(chain.grasp_pose(configurations(chain, 1)[0]))
        found = list(solver(name)(chain, target, np.random.default_rng(3), (), 20))
        assert len(found) > 2
        assert min(np.abs(a - b).max() for k, a in enumerate(found) for b in found[:k]) >= 0.05

    def test_what_is_out_of_reach_has_no_solution(self, chains, name, robot):
        far = Target(pin.SE3(np.eye(3), np.array([3.0, 0.0, 0.5])))
        assert solve(chains[robot], far, np.random.default_rng(0), restarts=4, kinematics=name) is None

    def test_a_solution_must_be_accepted(self, chains, name, robot):
        chain = chains[robot]
        seed = configurations(chain, 1, seed=7)[0]
        target = Target(chain.grasp_pose(seed))
        other = solve(
            chain, target, np.random.default_rng(0), (seed,), 40, lambda q: np.abs(q - seed).max() > 0.3, name
        )
        assert np.abs(other - seed).max() > 0.3
        assert target.distance(chain, other) < TOLERANCE

    def test_the_nearest_solution_to_a_configuration_that_is_one_is_itself(self, chains, name, robot):
        chain = chains[robot]
        seed = configurations(chain, 1, seed=8)[0]
        q = nearest(chain, Target(chain.grasp_pose(seed)), np.random.default_rng(0), seed, kinematics=name)
        assert q == pytest.approx(seed, abs=2e-3)


def test_a_descent_near_its_end_stays_near(chain):
    home = named(robot_model(), "arm", "home").position
    pose = chain.grasp_pose(home)
    near = pin.SE3(pose.rotation, pose.translation + [0.01, -0.01, 0.01])
    assert np.abs(solve_from(chain, Target(near), home) - home).max() < 0.1


@pytest.mark.parametrize("free", FREEDOMS)
def test_the_error_of_a_target_has_the_derivative_that_it_says(chain, free):
    q, step = configurations(chain, 2, seed=4), 1e-6
    target = Target(chain.grasp_pose(q[0] + 0.2 * (q[1] - q[0])), free)
    # Turns are told by their first order: exact for the whole pose, close to it for an axis that is nearly right.
    start = q[0] + 0.2 * (q[1] - q[0]) + (0.05 if free == "none" else 1e-3)
    error, jacobian = target.error(chain, start)
    columns = [(target.error(chain, start + step * row)[0] - error) / step for row in np.eye(len(start))]
    assert np.column_stack(columns) == pytest.approx(jacobian, abs=5e-3 if free != "none" else 1e-4)


def test_an_axis_that_points_the_wrong_way_round_is_turned(chain):
    home = named(robot_model(), "arm", "home").position
    pose = chain.grasp_pose(home)
    flipped = pin.SE3(pose.rotation @ pin.rpy.rpyToMatrix(np.pi, 0, 0), pose.translation)
    error, _ = Target(flipped, "z").error(chain, home)
    assert np.linalg.norm(error) == pytest.approx(np.pi)


def test_damped_least_squares_repeats_exactly(chain):
    target = Target(chain.grasp_pose(configurations(chain, 1)[0]))
    runs = [list(solver("damped_least_squares")(chain, target, np.random.default_rng(2), (), 20)) for _ in range(2)]
    assert all(np.array_equal(a, b) for a, b in zip(*runs, strict=True))


def test_an_unknown_solver_lists_those_that_exist():
    with pytest.raises(UnknownNameError, match=r"did you mean 'trac_ik'.*damped_least_squares"):
        solver("trac_ikk")


def test_an_unknown_freedom_lists_those_that_exist():
    with pytest.raises(UnknownNameError, match="orientation"):
        Target(pin.SE3.Identity(), "w")
