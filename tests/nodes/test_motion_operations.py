import numpy as np
import pytest

from grip_bt.base.failures import CanceledError, NoIkError, NoPlanError, PathInvalidError
from grip_bt.base.operation import Operation
from grip_bt.base.steps import run_steps
from grip_bt.base.values import Pose
from grip_bt.nodes.motion import OFF, first_of, go_straight, leaving


def test_first_of_ends_with_the_first_success_and_tries_no_more():
    tried = []

    def attempt(k, error):
        tried.append(k)
        return Operation.failed(error) if error else Operation.finished(k)

    whole = first_of([lambda: attempt(0, NoIkError("no")), lambda: attempt(1, None), lambda: attempt(2, None)])
    assert whole.result() == 1
    assert tried == [0, 1]


def test_first_of_ends_with_the_last_error_when_all_fail():
    whole = first_of([lambda: Operation.failed(NoIkError("a")), lambda: Operation.failed(NoPlanError("b"))])
    with pytest.raises(NoPlanError, match="b"):
        whole.result()


def test_first_of_nothing_is_no_plan():
    with pytest.raises(NoPlanError):
        first_of([]).result()


@pytest.mark.parametrize("error", [CanceledError("stop"), ZeroDivisionError("bug")])
def test_a_cancellation_and_a_bug_end_the_attempts(error):
    whole = first_of([lambda: Operation.failed(error), lambda: Operation.finished(1)])
    with pytest.raises(type(error)):
        whole.result()


def test_an_attempt_may_raise_instead_of_failing():
    def refuse():
        raise NoIkError("no")

    assert first_of([refuse, lambda: Operation.finished(1)]).result() == 1


def test_first_of_goes_on_when_a_pending_attempt_fails_and_cancels_the_one_under_way():
    canceled = []
    first, second = Operation(), Operation(on_cancel=lambda: canceled.append(2))
    whole = first_of([lambda: first, lambda: second])
    assert not whole.done()
    first.fail(NoIkError("no"))
    whole.cancel()
    assert canceled == [2]
    second.fail(CanceledError("canceled"))
    with pytest.raises(CanceledError):
        whole.result()


def test_thousands_of_attempts_that_end_at_once_do_not_overflow_the_stack():
    attempts = [lambda: Operation.failed(NoIkError("no"))] * 5000
    assert first_of([*attempts, lambda: Operation.finished(1)]).result() == 1


def test_what_a_straight_motion_ignores_is_put_back_as_it_was_also_when_planning_cannot_start(world):
    world.stand("seen_0", (0.5, 0.1))
    size, pose = world.scene.box("seen_0")

    def broken(verb, goal):
        assert "seen_0" not in world.scene.names()
        raise NoIkError("no")

    world.arm.on_plan = broken
    with pytest.raises(NoIkError):
        go_straight(world.arm, [Pose()], world.scene, ["seen_0", "not there"])
    assert np.array_equal(world.scene.box("seen_0")[0], size)
    assert world.scene.box("seen_0")[1] == pose
    assert "not there" not in world.scene.names()
    world.arm.on_plan, world.arm.held = lambda verb, goal: None, {"straight"}
    go_straight(world.arm, [Pose()], world.scene, ["seen_0"])
    assert "seen_0" not in world.scene.names()
    world.arm.finish()
    assert "seen_0" in world.scene.names()


TOUCHED = ("seen_0", "seen_1")


def in_contact(fraction):
    return PathInvalidError("touches", pairs=[TOUCHED], fraction=fraction)


def test_a_hand_may_leave_what_it_touches_where_it_is_and_nothing_else(world):
    for name, spot in zip(TOUCHED, ((0.5, 0.1), (0.5, 0.3)), strict=True):
        world.stand(name, spot)
    world.arm.errors["straight"].append(in_contact(0.0))
    allowed, here = [], world.arm.pose
    world.arm.on_plan = lambda verb, goal: allowed.append(world.scene.snapshot().may_touch(*TOUCHED))
    goal = here.moved([0, 0, 0.2])
    run_steps(leaving(world.arm, goal, world.scene)).result()
    assert allowed == [False, True, False]
    assert [goals for verb, goals in world.arm.log if verb == "straight"] == [[goal], [here.moved([0, 0, OFF])], [goal]]


def test_what_is_met_on_the_way_or_after_that_is_in_the_way(world):
    goal = world.arm.pose.moved([0, 0, 0.2])
    world.arm.errors["straight"].append(in_contact(0.3))
    with pytest.raises(PathInvalidError):
        run_steps(leaving(world.arm, goal, world.scene)).result()
    assert world.arm.verbs() == ["straight"]
    world.stand("seen_0")
    world.stand("seen_1", (0.5, 0.3))
    world.arm.errors["straight"].extend([in_contact(0.0), None, in_contact(0.0)])
    with pytest.raises(PathInvalidError):
        run_steps(leaving(world.arm, goal, world.scene)).result()
    assert not world.scene.snapshot().may_touch(*TOUCHED)
