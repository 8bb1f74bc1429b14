"""A cancel that comes while one part hands over to the next reaches the next one, and the whole ends only with that."""

from __future__ import annotations

import threading
from functools import partial

import numpy as np
import pytest
from patience import PATIENCE

from grip_bt.base.failures import CanceledError, NoPlanError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory
from grip_bt.commanders.joined import all_of
from grip_bt.commanders.pausing import PausableExecutor
from grip_bt.nodes.motion import first_of

ros = partial(pytest.param, marks=pytest.mark.ros)
WAY = Trajectory(("a",), np.array([0.0, 1.0]), np.array([[0.0], [1.0]]))


def after_then(first, step):
    return first.then(lambda _: step())


def after_first_of(first, step):
    failing = Operation(on_cancel=lambda: None)
    first.add_done_callback(lambda: failing.fail(NoPlanError("no")))
    return first_of([lambda: failing, step])


def after_walk(first, step):
    from grip_bt.base.steps import run_steps

    def calls():
        yield first
        return (yield step())

    return run_steps(calls())


def after_line(first, step):
    from grip_bt.base.steps import Sequencer

    line = Sequencer()
    line.submit(lambda: first)
    return line.submit(step)


def after_held(first, step):
    """A motion in a pause, which is gone on with when `first` ends."""

    class Inner:
        joint_names = ("a",)

        def execute(self, trajectory):
            return step()

        def state(self):
            return JointState(("a",), [0.0])

    held = PausableExecutor(Inner())
    held.pause()
    first.add_done_callback(held.resume)
    return held.execute(WAY)


@pytest.mark.parametrize("combined", [after_then, after_first_of, ros(after_walk), ros(after_line), after_held])
def test_a_cancel_in_the_middle_of_a_hand_over_reaches_what_is_begun(combined):
    first, second = Operation(on_cancel=lambda: None), Operation(on_cancel=lambda: None)
    begun = []

    def step():
        canceller = threading.Thread(target=whole.cancel)
        canceller.start()
        canceller.join(PATIENCE)
        begun.append(second)
        return second

    whole = combined(first, step)
    first.succeed(None)
    assert begun
    assert second.cancel_asked
    assert not whole.done(), "what was begun hasn't stopped yet"
    second.fail(CanceledError("stopped"))
    with pytest.raises(CanceledError, match="stopped"):
        whole.result()


def test_what_is_begun_while_another_part_fails_is_cancelled_and_waited_for():
    failing, late = Operation(), Operation(on_cancel=lambda: None)

    def start():
        failing.fail(NoPlanError("no"))
        return late

    whole = all_of({"one": lambda: failing, "other": start})
    assert late.cancel_asked
    assert not whole.done()
    late.fail(CanceledError("stopped"))
    with pytest.raises(NoPlanError):
        whole.result()


@pytest.mark.ros
def test_what_waits_for_its_turn_ends_at_once_and_never_begins():
    from grip_bt.base.steps import Sequencer

    line, begun, held = Sequencer(), [], Operation()
    line.submit(lambda: held)
    waiting = line.submit(lambda: begun.append(1))
    waiting.cancel()
    with pytest.raises(CanceledError):
        waiting.result()
    held.succeed(None)
    assert not begun
