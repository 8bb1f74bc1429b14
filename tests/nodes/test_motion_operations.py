import numpy as np
import pytest

from grip_bt.base.failures import CanceledError, NoIkError, NoPlanError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Pose
from grip_bt.nodes.motion import first_of, without


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


def test_without_puts_objects_back_as_they_were_also_when_planning_cannot_start(world):
    world.stand("seen_0", (0.5, 0.1))
    size, pose = world.scene.box("seen_0")

    def broken():
        assert "seen_0" not in world.scene.names()
        raise NoIkError("no")

    with pytest.raises(NoIkError):
        without(world.scene, ["seen_0", "not there"], broken)
    assert np.array_equal(world.scene.box("seen_0")[0], size)
    assert world.scene.box("seen_0")[1] == pose
    assert "not there" not in world.scene.names()
    pending = Operation()
    without(world.scene, ["seen_0"], lambda: pending)
    assert "seen_0" not in world.scene.names()
    pending.succeed(Pose())
    assert "seen_0" in world.scene.names()
