"""Motions of arm and hand in a running simulation."""

from __future__ import annotations

import numpy as np
import pytest
from sim_bench import AT, SPEC, SPOT, Bench

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import CanceledError, ExecutionAbortedError
from grip_bt.base.ports import Executor, HandPort
from grip_bt.base.values import JointState, Trajectory
from grip_bt.commanders.description.load import build_robot
from grip_sim.motions import LONGEST, MoveHand
from grip_sim.simulation import start_simulation
from grip_sim.specs import ObjectSpec, WorldSpec
from grip_sim.world import World

pytestmark = pytest.mark.sim


def turned(bench, by=0.4):
    return bench.arm.state().position + by * np.array([1, 0, 0, 0, 0, 0, 1.0])


def test_adapters_satisfy_their_protocols(bench):
    assert isinstance(bench.arm, Executor)
    assert isinstance(bench.hand, HandPort)


@pytest.mark.parametrize("height", [0.03, 3.0, 200.0])
def test_a_world_begins_when_its_objects_lie_still(height):
    fallen = ObjectSpec("fallen", "box", 0.05, 0.05, (0.5, 0.3, height))
    with start_simulation(WorldSpec(objects=(fallen,))) as simulation:
        simulation.keep_to_simulated(True)
        assert simulation.clock.now() < 0.6 or height >= 3.0, "what stands isn't waited for"
        here = simulation.referee.truth()["fallen"].pose.position
        assert here[2] == pytest.approx(0.025, abs=0.01)
        simulation.settle(0.5)
        assert simulation.referee.truth()["fallen"].pose.position == pytest.approx(here, abs=1e-3)


def test_what_goes_on_moving_is_not_waited_for():
    falling = ObjectSpec("falling", "box", 0.05, 0.05, (0.5, 0.3, 2000.0))
    with start_simulation(WorldSpec(objects=(falling,))) as simulation:
        simulation.keep_to_simulated(True)
        assert simulation.clock.now() == pytest.approx(LONGEST, abs=0.1)
        assert simulation.referee.truth()["falling"].pose.position[2] > 1.0


def test_a_motion_ends_at_its_goal_and_at_rest(bench):
    goal = turned(bench)
    end = bench.go(goal)
    assert end.position == pytest.approx(goal, abs=0.02)
    assert np.abs(end.velocity).max() < 0.05


def test_joints_keep_close_to_the_path_when_it_gives_no_velocities(bench):
    # half way and at half time the drives must not lag behind by what damping would cost without velocities
    goal, start = turned(bench, 1.0), bench.arm.state().position
    way = bench.way(goal, 1.0)
    half = Trajectory(way.names, way.times[:21], way.positions[:21])
    operation = bench.arm.execute(half)
    end = bench.wait(operation)
    assert end.position == pytest.approx((start + goal) / 2, abs=0.02)


def test_a_way_of_one_point_is_held(bench):
    here = bench.arm.state().position
    end = bench.wait(bench.arm.execute(Trajectory(bench.arm.joint_names, [0.0], [here])))
    assert end.position == pytest.approx(here, abs=0.01)


def test_a_way_that_begins_elsewhere_is_aborted_and_nothing_moves(bench):
    before = bench.arm.state().position
    far = bench.way(before + 0.3, start=before + 0.1)
    with pytest.raises(ExecutionAbortedError, match=r"panda_joint\d is 0.1\d\d rad away from the start"):
        bench.wait(bench.arm.execute(far))
    bench.simulation.settle(0.2)
    assert bench.arm.state().position == pytest.approx(before, abs=0.01)


@pytest.mark.parametrize("paced", [False, True], ids=["straight", "with speeds"])
def test_joints_that_moved_on_since_they_were_measured_do_not_go_back(bench, paced):
    """As those of a stream of set-points do, where the thread of one waits for a busy machine's processor."""
    measured, goal = bench.arm.state().position, turned(bench)
    bench.arm.execute(Trajectory(bench.arm.joint_names, [0.0, 2.0], [measured, goal]))
    bench.simulation.settle(0.2)
    speeds = np.array([goal - measured, 0 * goal]) / 2.0 if paced else None
    where = [bench.arm.state().position[0]]
    operation = bench.simulation.executor("arm", from_here=True).execute(
        Trajectory(bench.arm.joint_names, [0.0, 1.5], [measured, goal], speeds)
    )
    while not operation.done():
        bench.simulation.settle(0.01)
        where.append(bench.arm.state().position[0])
    assert where[0] > measured[0] + 0.03
    assert np.diff(where).min() > -1e-3
    assert bench.wait(operation).position == pytest.approx(goal, abs=0.02)


def test_a_way_that_can_not_be_followed_is_aborted_and_the_arm_presses_no_longer(bench):
    down = bench.arm.state().position + np.array([0, 0.75, 0, 0, 0, 0, 0.0])  # into the table
    with pytest.raises(ExecutionAbortedError, match="away from the end"):
        bench.go(down)
    bench.simulation.settle(0.3)
    assert np.abs(bench.arm.state().effort).max() < 24  # 30 N, 0.8 m away; nothing holds it on the table but its weight


@pytest.mark.parametrize("how", ["cancel", "stop"])
def test_a_stopped_arm_holds_where_it_is(bench, how):
    goal = turned(bench, 1.0)
    start = bench.arm.state().position
    operation = bench.arm.execute(Trajectory(bench.arm.joint_names, [0.0, 200.0], [start, goal]))
    bench.simulation.settle(1.0)
    operation.cancel() if how == "cancel" else bench.arm.stop()
    with pytest.raises(CanceledError):
        bench.wait(operation)
    bench.simulation.settle(1.0)
    held = bench.arm.state().position
    bench.simulation.settle(5.0)
    assert bench.arm.state().position == pytest.approx(held, abs=0.01)
    assert np.abs(held - goal).max() > 0.5


def test_a_second_command_to_the_same_joints_ends_the_first_as_canceled(bench):
    first = bench.arm.execute(bench.way(turned(bench), 1000.0))
    here = bench.arm.state().position
    second = bench.arm.execute(bench.way(here, 0.3, start=here))
    with pytest.raises(CanceledError):
        bench.wait(first)
    assert bench.wait(second).position == pytest.approx(here, abs=0.02)


def test_arm_and_hand_move_at_once(bench):
    goal = turned(bench)
    began = bench.simulation.clock.simulated
    bench.simulation.pause()
    arm = bench.arm.execute(bench.way(goal, 2.0))
    hand = bench.hand.move(bench.half_closed, 2.0)
    bench.simulation.resume()
    assert bench.wait(arm).position == pytest.approx(goal, abs=0.02)
    assert bench.wait(hand).ordered(bench.opened.names) == pytest.approx(bench.half_closed.position, abs=0.05)
    assert bench.simulation.clock.simulated - began < 3.5


def test_stopping_the_hand_leaves_the_arm_on_its_way(bench):
    goal = turned(bench)
    arm = bench.arm.execute(bench.way(goal, 2.0))
    hand = bench.hand.move(bench.closed, 1000.0)
    bench.hand.stop()
    with pytest.raises(CanceledError):
        bench.wait(hand)
    assert bench.wait(arm).position == pytest.approx(goal, abs=0.02)


@pytest.mark.parametrize("moment", [0.05, 0.3, 0.6])
def test_fingers_that_are_stopped_are_at_rest_soon_after_braking_at_their_limits(moment):
    world, hand = World(WorldSpec()), build_robot("panda_allegro").named_states["hand"]
    robot, rows = world.robot, world.robot.rows(world.robot.description.group("hand"))
    names = robot.measure(rows).names
    thumb = set(hand["open"].names[-4:])  # would meet the fingers
    opened, closed = hand["open"].as_mapping(), hand["closed"].as_mapping()
    goal = np.array([(opened if name in thumb else closed)[name] for name in names])
    motion, moving, end = MoveHand(robot, rows, goal, 1.0, world.time), [], None
    while world.time < moment:
        motion.advance(world)
        world.step()
    asked, fastest = world.time, np.abs(robot.velocities()[rows]).max()
    motion = motion.braking(world)
    while end is None:
        end = motion.advance(world)
        world.step()
    assert (end.error, end.stopped) == ("canceled", True)
    ended, there = world.time, robot.positions()[rows]
    while world.time < ended + 0.3:
        moving.extend([world.time] * bool(np.abs(robot.velocities()[rows]).max() > 0.02))
        world.step()
    assert fastest > 0.5
    assert max(moving, default=ended) - asked < fastest / robot.accelerations(rows).min() + 0.15
    assert robot.positions()[rows] == pytest.approx(there, abs=4e-3)


@pytest.mark.parametrize("limit", [0.2, 0.5])
def test_fingers_press_with_no_more_than_the_torque_limit(bench, limit):
    bench.go(AT)
    bench.referee.move_object("thing", SPOT)
    end = bench.wait(bench.hand.move(bench.closed, 1.2, limit))
    assert bench.hand.contacts()
    assert np.abs(end.effort).max() == pytest.approx(limit, rel=1e-3)  # blocked, so that the limit is reached


def test_what_is_stopped_at_rest_keeps_pressing(bench):
    bench.grasp()
    force = sum(bench.hand.contacts().values())
    bench.hand.stop()
    bench.simulation.settle(0.5)
    assert sum(bench.hand.contacts().values()) > 0.5 * force
    assert bench.truth().status == "held"


def test_the_same_commands_after_the_same_start_give_the_same_world():
    prints = []
    for _ in range(2):
        with start_simulation(SPEC) as simulation:
            bench = Bench(simulation)
            bench.go(turned(bench))
            bench.wait(bench.hand.move(bench.closed, 0.8))
            prints.append(bench.referee.fingerprint())
    assert prints[0] == prints[1]


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_goals_that_are_no_numbers_are_refused_before_anything_moves(bench, bad):
    way = bench.way(turned(bench))
    positions = way.positions.copy()
    positions[20, 3] = bad
    with pytest.raises(ValueError, match="a trajectory must consist of finite numbers"):
        bench.arm.execute(Trajectory(way.names, way.times, positions))
    posture = JointState(bench.closed.names, np.full(16, bad))
    with pytest.raises(ValueError, match="a posture must consist of finite numbers"):
        bench.hand.move(posture, 1.0)


@pytest.mark.parametrize(("duration", "limit"), [(0.0, None), (-1.0, None), (np.nan, None), (1.0, 0.0), (1.0, -1.0)])
def test_durations_and_torque_limits_are_positive(bench, duration, limit):
    with pytest.raises(ValueError, match="must be a positive number"):
        bench.hand.move(bench.closed, duration, limit)


def test_a_trajectory_for_other_joints_is_refused(bench):
    with pytest.raises(ValueError, match="not for"):
        bench.arm.execute(Trajectory(("a", "b"), [0.0, 1.0], np.zeros((2, 2))))


def test_joints_may_come_in_any_order(bench):
    goal = turned(bench)
    way = bench.way(goal)
    turn = list(reversed(range(7)))
    names = tuple(way.names[i] for i in turn)
    end = bench.wait(bench.arm.execute(Trajectory(names, way.times, way.positions[:, turn])))
    assert end.ordered(way.names) == pytest.approx(goal, abs=0.02)


def test_states_carry_the_time_of_the_runs_clock(bench):
    before = bench.simulation.clock.now()
    measured = bench.arm.state()
    assert before <= measured.time <= bench.simulation.clock.now()


def test_unknown_groups_and_cameras_list_those_that_exist(bench):
    with pytest.raises(UnknownNameError, match="arm"):
        bench.simulation.executor("amr")
    with pytest.raises(UnknownNameError, match="overhead"):
        bench.simulation.camera("overhaed")
