"""Who answers the requests of an arm that another planner plans for."""

import pytest

from grip_bt.app.wiring.commanders import PlannerByName
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.commanders.planning.requests import (
    CheckTogether,
    CheckTrajectory,
    ChooseGrasp,
    PlanStraight,
    PlanTo,
    Situation,
)
from grip_bt.commanders.scene_state import SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings

START = JointState(("a",), [0.0])
ROAD = Trajectory(("a",), [0.0, 1.0], [[0.0], [1.0]])


class Asked:
    def __init__(self):
        self.requests = []

    def submit(self, request):
        self.requests.append(request)
        return Operation.finished(None)


def asked(request_of, planner):
    """Return who was asked, of our own planner and of one that is called `theirs`."""
    own, theirs = Asked(), Asked()
    situation = Situation("arm", START, SceneSnapshot(), "", PlanningSettings(planner=planner, planning_time=60.0))
    request = request_of(situation)
    PlannerByName(own, {"theirs": theirs}).submit(request)
    assert own.requests + theirs.requests == [request]
    return "theirs" if theirs.requests else "own"


SEARCHES = [lambda s: PlanTo(s, START), lambda s: PlanStraight(s, (Pose(),)), lambda s: ChooseGrasp(s, ())]
GIVEN = [lambda s: CheckTrajectory(s, ROAD), lambda s: CheckTogether(s, ())]


@pytest.mark.parametrize("request_of", SEARCHES)
def test_a_search_goes_to_the_planner_that_the_arm_names(request_of):
    assert asked(request_of, "theirs") == "theirs"
    assert asked(request_of, "rrt_connect") == "own"


@pytest.mark.parametrize("request_of", GIVEN)
def test_a_motion_that_is_given_is_looked_at_by_ours_whoever_plans_for_the_arm(request_of):
    assert asked(request_of, "theirs") == "own"
