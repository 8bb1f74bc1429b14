import numpy as np
import pinocchio as pin
import pytest
from table_top import named

from grip_bt.commanders.ik import solver
from grip_bt.commanders.ik.damped_least_squares import solutions, solve, solve_from
from grip_bt.errors import UnknownNameError


@pytest.fixture
def chain(model):
    return model.chain("arm")


def reachable_poses(chain, count, seed):
    rng = np.random.default_rng(seed)
    return [chain.grasp_pose(q) for q in rng.uniform(chain.limits.lower, chain.limits.upper, (count, 7))]


def test_nearly_every_reachable_pose_is_solved_exactly_and_within_the_limits(chain):
    rng = np.random.default_rng(0)
    solved = 0
    for pose in reachable_poses(chain, 100, seed=1):
        q = solve(chain, pose, rng)
        if q is not None:
            solved += 1
            assert chain.within_limits(q)
            error = pin.log6(chain.grasp_pose(q).actInv(pose)).vector
            assert np.linalg.norm(error) < 1.1e-4
    assert solved >= 97


def test_a_solution_near_its_seed_stays_near(chain, model):
    home = named(model, "arm", "home").position
    pose = chain.grasp_pose(home)
    near = pin.SE3(pose.rotation, pose.translation + [0.01, -0.01, 0.01])
    assert np.abs(solve_from(chain, near, home) - home).max() < 0.1


def test_solutions_are_distinct_and_those_of_seeds_come_first(chain, model):
    home = named(model, "arm", "home").position
    found = list(solutions(chain, chain.grasp_pose(home), np.random.default_rng(3), seeds=(home,), restarts=20))
    assert found[0] == pytest.approx(home, abs=1e-3)
    assert len(found) > 3
    distances = [np.abs(a - b).max() for k, a in enumerate(found) for b in found[:k]]
    assert min(distances) >= 0.05


def test_what_is_out_of_reach_has_no_solution(chain):
    far = pin.SE3(np.eye(3), np.array([2.0, 0.0, 0.5]))
    assert solve(chain, far, np.random.default_rng(0)) is None


def test_a_solution_must_be_accepted(chain, model):
    home = named(model, "arm", "home").position
    pose, rng = chain.grasp_pose(home), np.random.default_rng(0)
    q = solve(chain, pose, rng, seeds=(home,), accept=lambda q: np.abs(q - home).max() > 0.3)
    assert np.abs(q - home).max() > 0.3


def test_an_unknown_solver_lists_those_that_exist():
    with pytest.raises(UnknownNameError, match="damped_least_squares"):
        solver("trac_ikk")
