"""An operation ends exactly once, tells whoever waits, and passes cancelling on."""

import asyncio
import threading

import pytest

from grip_bt.base.failures import CanceledError, NoIkError
from grip_bt.base.operation import Operation


def test_it_ends_once_and_keeps_its_first_end():
    operation = Operation()
    assert operation.succeed(1)
    assert not operation.succeed(2)
    assert not operation.fail(ValueError())
    assert operation.result() == 1


def test_the_result_before_the_end_is_a_mistake_of_the_caller():
    with pytest.raises(RuntimeError, match="hasn't ended"):
        Operation().result()


def test_callbacks_are_called_once_and_at_once_after_the_end():
    calls = []
    operation = Operation()
    operation.add_done_callback(lambda: calls.append("before"))
    operation.succeed(None)
    operation.add_done_callback(lambda: calls.append("after"))
    assert calls == ["before", "after"]


def test_a_callback_that_raises_keeps_no_other_waiting():
    def broken():
        raise ValueError("broken")

    calls = []
    operation = Operation()
    operation.add_done_callback(broken)
    operation.add_done_callback(lambda: calls.append("after"))
    with pytest.raises(ValueError, match="broken"):
        operation.succeed(1)
    assert calls == ["after"]
    assert operation.result() == 1


def test_cancelling_asks_the_work_once():
    asked = []
    operation = Operation(on_cancel=lambda: asked.append(1))
    operation.cancel()
    operation.cancel()
    assert asked == [1]
    assert not operation.done()


def test_cancelling_without_work_ends_at_once():
    operation = Operation()
    operation.cancel()
    with pytest.raises(CanceledError):
        operation.result()


def test_cancelling_after_the_end_changes_nothing():
    operation = Operation.finished(3)
    operation.cancel()
    assert operation.result() == 3


def test_steps_follow_one_another():
    first, second = Operation(), Operation()
    whole = first.then(lambda r: second)
    first.succeed(1)
    assert not whole.done()
    second.succeed(2)
    assert whole.result() == 2


@pytest.mark.parametrize("where", ["first", "second", "step"])
def test_an_error_of_any_part_ends_the_whole(where):
    def step(_):
        if where == "step":
            raise NoIkError("x")
        return Operation.failed(NoIkError("x"))

    first = Operation.failed(NoIkError("x")) if where == "first" else Operation.finished(1)
    with pytest.raises(NoIkError):
        first.then(step).result()


def test_cancelling_the_whole_cancels_the_part_under_way():
    first, second = Operation(), Operation()
    whole = first.then(lambda r: second)
    first.succeed(1)
    whole.cancel()
    assert second.cancel_asked
    with pytest.raises(CanceledError):
        whole.result()


def test_a_step_is_not_begun_after_cancelling():
    begun = []
    first = Operation(on_cancel=lambda: None)
    whole = first.then(lambda r: begun.append(r))
    whole.cancel()
    first.succeed(1)
    assert not begun
    with pytest.raises(CanceledError):
        whole.result()


def test_whoever_waits_in_another_thread_is_released():
    operation = Operation()
    thread = threading.Thread(target=lambda: operation.succeed(5))
    thread.start()
    assert operation.wait(120)
    assert operation.result() == 5
    thread.join()


def test_work_says_how_far_it_is_also_through_what_follows_it():
    first: Operation[int] = Operation()
    whole = first.then(lambda result: Operation.finished(result + 1))
    assert whole.progress is None
    first.report(0.5)
    assert (first.progress, whole.progress) == (0.5, 0.5)
    first.succeed(1)
    assert (whole.result(), whole.progress) == (2, 0.5)


def test_work_that_is_still_busy_lingers_after_its_cancelled_end():
    operation = Operation()
    operation.busy = True
    operation.fail(CanceledError("canceled"))
    assert not operation.lingers
    operation = Operation()
    operation.busy = True
    operation.cancel()
    assert (operation.done(), operation.lingers) == (True, True)
    operation.busy = False
    assert not operation.lingers


def test_a_coroutine_that_waits_goes_on_when_another_thread_ends_it():
    operation = Operation()

    async def wait() -> object:
        asyncio.get_running_loop().call_soon(threading.Thread(target=operation.succeed, args=["done"]).start)
        return await asyncio.wait_for(asyncio.ensure_future(awaited()), 60)

    async def awaited() -> object:
        return await operation

    assert asyncio.run(wait()) == "done"
