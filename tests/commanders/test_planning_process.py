"""The planning process: it answers, it repeats itself, and it never outlives or blocks its parent."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from table_top import endless_request, named, place_things, robot_model, room, side_grasps, situation

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import CanceledError, GoalInCollisionError, PlannerLostError
from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.planning import service
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import ChooseGrasp, PlanTo
from grip_bt.commanders.planning.service import PlanningProcess
from grip_bt.commanders.settings import PLANNERS


@pytest.fixture(scope="module")
def planner():
    with PlanningProcess(robot_model().description) as process:
        assert process.wait_until_ready()
        yield process


def reachable_request(seed=0):
    model = robot_model()
    home = named(model, "arm", "home")
    goal = JointState(home.names, home.position + [0.6 - 0.1 * seed, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0])
    return PlanTo(situation(model, room(model).snapshot(), seed=seed), goal)


def ended(operation, within=120.0):
    assert operation.wait(within)
    return operation


def test_answers_are_those_of_the_same_request_in_this_process(planner):
    request = reachable_request()
    assert (
        ended(planner.submit(request)).result().trajectory == answer(robot_model(), request, lambda: False).trajectory
    )


def test_requests_are_answered_in_order_and_each_with_its_own_result(planner):
    operations = [planner.submit(reachable_request(seed)) for seed in range(3)]
    results = [ended(operation).result() for operation in operations]
    again = [ended(planner.submit(reachable_request(seed))).result() for seed in range(3)]
    assert [r.trajectory for r in results] == [r.trajectory for r in again]


def test_expected_errors_come_back_with_their_data(planner):
    model, scene = robot_model(), room(robot_model())
    scene.set_box("block", (0.1, 0.1, 0.1), Pose(model.grasp_pose(_away(model)).position))
    operation = ended(planner.submit(PlanTo(situation(model, scene.snapshot()), _away(model))))
    with pytest.raises(GoalInCollisionError) as caught:
        operation.result()
    assert any("block" in pair for pair in caught.value.data["pairs"])


def _away(model):
    home = named(model, "arm", "home")
    return JointState(home.names, home.position + [0.8, 0, 0, 0, 0, 0, 0])


def test_errors_with_unusual_constructors_come_back_too(planner):
    request = PlanTo(reachable_request().situation, JointState(("panda_joint99",), [0.0]))
    with pytest.raises(UnknownNameError, match="panda_joint7"):
        ended(planner.submit(request)).result()


def test_a_grasp_is_chosen_there_too(planner):
    model, rng = robot_model(), np.random.default_rng(3)
    scene = room(model)
    grasps = tuple(g for thing in place_things(scene, rng) for g in side_grasps(thing, rng))
    chosen = ended(planner.submit(ChooseGrasp(situation(model, scene.snapshot()), grasps))).result()
    assert chosen.grasp in grasps


def test_cancelling_ends_an_endless_plan(planner):
    """How soon is measured in benchmarks/planning_process.py: within 50 ms, at the latest by replacing the process."""
    operation = planner.submit(endless_request())
    assert not operation.wait(0.5), "the request was to be endless"
    operation.cancel()
    with pytest.raises(CanceledError):
        ended(operation).result()
    ended(planner.submit(reachable_request())).result()


@pytest.mark.parametrize("search", ["RRTConnect", "PRM"])
def test_a_plan_ends_itself_when_it_is_cancelled_and_its_process_goes_on(planner, monkeypatch, search):
    monkeypatch.setattr(
        "grip_bt.commanders.planning.service.CANCEL_GRACE", 300.0
    )  # nothing but the search itself may end it
    assert planner.wait_until_ready()
    pid = planner.pid
    operation = planner.submit(endless_request(search))
    assert not operation.wait(0.5), "the request was to be endless"
    operation.cancel()
    with pytest.raises(CanceledError):
        ended(operation).result()
    ended(planner.submit(reachable_request())).result()
    assert planner.pid == pid


@pytest.mark.parametrize("search", PLANNERS)
def test_no_search_looks_at_anything_once_it_is_cancelled(search, monkeypatch):
    """Between two questions of its own a search may make thousands of checks; each of them ends it."""
    made, asked = [], []

    def canceled():
        asked.append(len(made))
        return len(asked) > 40

    for name in ("free", "all_free"):
        check = getattr(CollisionChecker, name)
        monkeypatch.setattr(CollisionChecker, name, lambda *a, check=check: made.append(1) or check(*a))
    with pytest.raises(CanceledError):
        answer(robot_model(), endless_request(search), canceled)
    assert len(made) - asked[40] <= 1


def test_a_request_that_ignores_its_cancellation_costs_the_process_not_the_caller(planner, monkeypatch):
    pid = planner.pid
    os.kill(pid, signal.SIGSTOP)  # hangs, as far as anybody can tell
    operation = planner.submit(reachable_request())
    operation.cancel()
    with pytest.raises(CanceledError):
        ended(operation).result()
    ended(planner.submit(reachable_request())).result()
    assert planner.pid != pid


def test_a_queued_request_can_be_cancelled_without_harm_to_the_one_under_way(planner):
    under_way, queued = planner.submit(endless_request()), planner.submit(reachable_request())
    pid = planner.pid
    queued.cancel()
    with pytest.raises(CanceledError):
        ended(queued).result()
    assert not under_way.done()
    assert planner.pid == pid
    under_way.cancel()
    ended(under_way)


def test_a_request_survives_the_death_of_the_process(planner):
    expected = ended(planner.submit(reachable_request())).result().trajectory
    operation = planner.submit(endless_request())
    follower = planner.submit(reachable_request())
    os.kill(planner.pid, signal.SIGKILL)
    assert planner.wait_until_ready()
    assert not operation.wait(0.3)
    operation.cancel()
    assert ended(follower).result().trajectory == expected


def test_a_request_that_kills_two_processes_is_given_up(planner):
    operation = planner.submit(endless_request())
    for _ in range(2):
        pid = planner.pid
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda pid=pid: planner.pid != pid)
        assert planner.wait_until_ready()
    with pytest.raises(PlannerLostError, match=f"died twice: process {pid} was ended by SIGKILL"):
        ended(operation).result()
    ended(planner.submit(reachable_request())).result()


def wait_until(condition, seconds=120.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_whoever_is_interested_is_told_of_a_death_and_of_no_other_end():
    told = []
    with PlanningProcess(robot_model().description, told.append) as process:
        assert process.wait_until_ready()
        pids = [process.pid]
        os.kill(process.pid, signal.SIGKILL)
        wait_until(lambda: told)
        pids.append(process.pid)
        operation = process.submit(endless_request())
        os.kill(process.pid, signal.SIGKILL)
        wait_until(lambda: len(told) == 2)
        pids.append(process.pid)
        operation.cancel()
        ended(operation)
    died = "process {} was ended by SIGKILL (Killed); process {} replaces it"
    assert told == [died.format(*pids[:2]), died.format(*pids[1:]) + ", and repeats the request"]


def test_a_process_that_cannot_start_is_reported_not_started_for_ever(monkeypatch, capfd):
    monkeypatch.setattr(service, "PROGRAM", "grip_bt.commanders.no_such_module")
    with PlanningProcess(robot_model().description) as process:
        assert not process.wait_until_ready()
        operation = process.submit(reachable_request())
        with pytest.raises(PlannerLostError):
            ended(operation).result()
    assert "no_such_module" in capfd.readouterr().err


def test_closing_ends_what_is_under_way_and_the_process():
    process = PlanningProcess(robot_model().description)
    operation = process.submit(endless_request())
    pid = process.pid
    process.close()
    process.close()
    with pytest.raises(CanceledError):
        operation.result()
    assert not alive(pid)
    with pytest.raises(RuntimeError, match="closed"):
        process.submit(reachable_request())


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_callers_on_several_threads_get_their_own_answers(planner):
    results = {}

    def ask(seed):
        results[seed] = ended(planner.submit(reachable_request(seed))).result().trajectory

    threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    own = {s: answer(robot_model(), reachable_request(s), lambda: False).trajectory for s in range(4)}
    assert results == own
    assert len({trajectory.positions[-1, 0] for trajectory in own.values()}) == 4, "else a mix-up wouldn't be seen"


PARENT = """
import sys, time
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.planning.service import PlanningProcess
planner = PlanningProcess(build_robot("panda_allegro"))
planner.wait_until_ready()
print(planner.pid, flush=True)
time.sleep(600)
"""


def test_no_orphan_is_left_when_the_parent_is_killed():
    parent = subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE, text=True)
    child = int(parent.stdout.readline())
    assert alive(child)
    parent.kill()
    parent.wait()
    parent.stdout.close()
    wait_until(lambda: not alive(child), seconds=10)
