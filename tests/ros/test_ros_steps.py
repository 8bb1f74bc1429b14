"""Several calls as one operation."""

import pytest

from grip_bt.base.failures import CanceledError, NoPlanError
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Sequencer, run_steps

pytestmark = pytest.mark.ros


def test_steps_go_on_with_results_and_errors_and_stop_where_they_are_cancelled():
    parts = [Operation(), Operation(), Operation()]

    def work():
        first = yield parts[0]
        try:
            yield parts[1]
        except NoPlanError:
            second = yield parts[2]
            return first + second

    whole = run_steps(work())
    parts[0].succeed(1)
    parts[1].fail(NoPlanError("no"))
    parts[2].succeed(2)
    assert whole.result() == 3

    line, held, begun = Sequencer(), Operation(), []
    first = line.submit(lambda: held)
    second = line.submit(lambda: begun.append(2) or Operation.finished(2))
    third = line.submit(lambda: begun.append(3) or Operation.finished(3))
    second.cancel()
    held.succeed(1)
    assert (first.result(), third.result(), begun) == (1, 3, [3])
    with pytest.raises(CanceledError):
        second.result()
    raised = line.submit(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        raised.result()
    assert line.submit(lambda: Operation.finished(4)).result() == 4
