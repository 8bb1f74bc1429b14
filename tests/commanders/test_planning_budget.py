"""A search may take so much time of work: a machine that is busy with other things doesn't cut it short, for long."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest
from table_top import endless_request, place_things, robot_model, room, side_grasps, situation

from grip_bt.base.failures import TimeOutError
from grip_bt.base.values import WayPoint
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.budget import BACKSTOP, RATE, REAL, Budget, Clocks
from grip_bt.commanders.planning.grasps import GraspSearch
from grip_bt.commanders.planning.requests import ChooseGrasp, PlanThrough, PlanTo


class Ticking:
    """A clock that goes on by a step each time that somebody looks, the first time excepted."""

    def __init__(self, step: float = 0.0, first: float = 0.0):
        self.step, self.first, self.looks = step, first, 0

    def __call__(self) -> float:
        self.looks += 1
        return 0.0 if self.looks == 1 else self.first + self.step * (self.looks - 1)


def starved(limit: float) -> Clocks:
    """Clocks of a thread that had hardly worked when nearly all of the wall time had passed."""
    return Clocks(Ticking(limit * 1e-6), Ticking(limit * 1e-6, first=limit * BACKSTOP * 0.9))


def never() -> bool:
    return False


def answered(model, request, clocks: Clocks):
    """Return the answer that is found by the time of some clocks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("grip_bt.commanders.planning.budget.REAL", clocks)
        return answer(model, request, never)


@pytest.fixture(scope="module")
def table():
    model, rng = robot_model(), np.random.default_rng(3)
    scene = room(model)
    grasps = tuple(g for thing in place_things(scene, rng) for g in side_grasps(thing, rng))
    return model, situation(model, scene.snapshot()), grasps


@pytest.fixture(scope="module")
def chosen(table):
    model, begin, grasps = table
    return answer(model, ChooseGrasp(begin, grasps), never)


def limited(begin, seconds: float, **settings):
    changed = begin.settings.model_copy(update={"planning_time": seconds, **settings})
    return dataclasses.replace(begin, settings=changed)


@pytest.mark.parametrize("planner", ["RRTConnect", "BiTRRT", "KPIECE1"])
def test_a_plan_is_found_by_a_thread_that_hardly_gets_to_work(table, chosen, planner):
    model, begin, _ = table
    request = PlanTo(limited(begin, 1000.0, planner=planner), chosen.at_pre_grasp)
    plan = answered(model, request, starved(1000.0))
    assert plan.trajectory == answered(model, request, Clocks(Ticking(), Ticking())).trajectory


def test_so_are_motions_through_way_points_and_the_way_to_a_grasp(table, chosen):
    model, begin, grasps = table
    request = PlanThrough(limited(begin, 1000.0), (WayPoint(chosen.at_pre_grasp, straight=False),))
    assert answered(model, request, starved(1000.0)).planner == "through"
    assert answered(model, ChooseGrasp(begin, grasps), starved(1.0)).grasp == chosen.grasp


@pytest.mark.parametrize("planner", ["RRTConnect", "BiTRRT", "KPIECE1", "PRM"])
def test_work_ends_a_search_though_no_wall_time_passed(planner):
    request = endless_request(planner)
    worked = Ticking(step=0.01)
    request = dataclasses.replace(request, situation=limited(request.situation, 1.0))
    with pytest.raises(TimeOutError, match=r"no path within [0-9.e-]+ s of CPU time") as caught:
        answered(robot_model(), request, Clocks(worked, Ticking()))
    assert caught.value.data["planner"] == planner
    assert worked.looks >= 100


@pytest.mark.parametrize("planner", ["RRTConnect", "BiTRRT", "KPIECE1", "PRM"])
def test_wall_time_ends_it_in_the_end_though_no_work_was_done(planner):
    request = endless_request(planner)
    passed = Ticking(step=0.1)
    request = dataclasses.replace(request, situation=limited(request.situation, 1.0))
    said = r"in which it got only 0 of its [0-9.]+ s of CPU time: the machine is busy"
    with pytest.raises(TimeOutError, match=said):
        answered(robot_model(), request, Clocks(Ticking(), passed))
    assert passed.looks >= BACKSTOP * 1.0 / 0.1


def test_the_way_to_a_grasp_gets_so_much_work_whatever_time_that_takes(table, chosen, monkeypatch):
    model, begin, _ = table

    can_go_to = GraspSearch.can_go_to

    def reached(worked: Ticking) -> list[bool]:
        """Return which ways were found to all that reach the grasp: none is taken."""
        found: list[bool] = []

        def noted(*asked) -> bool:
            found.append(can_go_to(*asked))
            return False

        monkeypatch.setattr("grip_bt.commanders.planning.budget.REAL", Clocks(worked, Ticking()))
        monkeypatch.setattr(GraspSearch, "can_go_to", noted)
        assert GraspSearch(model, begin).tried(chosen.grasp, never) in ("no_plan", "lift_blocked")
        return found

    assert reached(Ticking(step=1e-6)) == reached(Ticking(step=1e-4))
    with pytest.raises(TimeOutError):  # only where the direct way is free, there is no search
        reached(Ticking(step=11.0))


def test_a_budget_is_shared_out_by_work_and_ended_by_time():
    worked, passed = [0.0], [0.0]
    whole = Budget(6.0, Clocks(lambda: worked[0], lambda: passed[0]))
    assert (whole.wall_left, whole.over()) == (6.0 * BACKSTOP, False)
    third = whole.share(3)
    asked = 1
    while not third.over():
        asked += 1
    assert asked == pytest.approx(RATE * 2.0, abs=2)
    assert not whole.out_of_time
    assert "its share of the work" in str(third)
    half = whole.share(2)
    assert not half.over(RATE * 2.0 - 2)
    assert half.over(5)
    last = whole.share(1)
    assert not last.over(1e9)
    worked[0] = 6.1
    assert last.over()
    assert half.out_of_time
    assert str(half) == str(last) == "within 6 s of CPU time"
    worked[0], passed[0] = 4.0, 121.0
    assert half.over(0.0)
    assert str(half) == "within 120 s, in which it got only 4 of its 6 s of CPU time: the machine is busy"


@pytest.mark.parametrize("planner", ["RRTConnect", "BiTRRT", "KPIECE1"])
def test_how_fast_the_machine_is_decides_whether_there_is_a_plan_and_not_which(table, chosen, planner):
    model, begin, _ = table
    found = []
    for tick in (1e-7, 1e-5, 1e-4, 1e-3, 1e-2):
        request = PlanTo(limited(begin, 2.0, planner=planner), chosen.grasp.pre_grasp)
        try:
            found.append(answered(model, request, Clocks(Ticking(tick), Ticking())).trajectory)
        except TimeOutError:
            found.append(None)
    plans = [trajectory for trajectory in found if trajectory is not None]
    assert plans
    assert all(trajectory == plans[0] for trajectory in plans)


def test_what_counts_is_the_time_of_the_thread_that_searches():
    """Not that of the process: others read messages, and share a batch of collision checks, meanwhile."""
    assert REAL == (time.thread_time, time.monotonic)
