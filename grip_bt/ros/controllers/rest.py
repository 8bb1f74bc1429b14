"""When joints are at rest: by where they are measured, and when that was; no clock of ours takes part in it."""

from __future__ import annotations

from grip_bt.base.failures import CanceledError, ExecutionAbortedError, ExpectedError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState
from grip_bt.commanders.stillness import Stillness

from .joint_states import JointStates

RESTS = 3.0
"""How long joints may take until they are measured at rest [s]."""


def rest_of_joints(states: JointStates, names: tuple[str, ...], within: float = RESTS) -> Operation[str]:
    """Return an operation that ends when joints are measured at rest; its result is empty then.

    Where they aren't `within` [s], the result says what is known instead.
    """
    judge = Stillness()

    def why() -> str:
        return f"{judge.moving} still moves" if judge.moving else "nothing was measured of the joints since"

    return states.watch(names, judge.see, within).then(
        lambda at_rest: Operation.finished("" if at_rest else f"after {within:g} s {why()}")
    )


class Motion:
    """A motion under way, which ends only with the joints at rest; see `whole`.

    Attributes:
        whole: ends as `part` does; with an error only when the joints were measured at rest, or that can't be
            confirmed, which the error then says (`stopped` in its data is False).

    Args:
        part: what moves the joints; its result is the motion's.
        states: where they are measured.
        names: the joints.
    """

    def __init__(self, part: Operation[JointState], states: JointStates, names: tuple[str, ...]):
        self._part, self._states, self._names = part, states, names
        self._overtaken = False
        self.whole: Operation[JointState] = Operation(on_cancel=part.cancel)
        part.add_done_callback(self._ended)

    def overtake(self) -> None:
        """End it for another motion that takes its place, and don't wait for joints that go on by that."""
        self._overtaken = True
        self.whole.cancel()
        if self._part.done():
            self.whole.fail(CanceledError("another motion has taken the place of this one"))

    def _ended(self) -> None:
        try:
            self.whole.succeed(self._part.result())
        except (CanceledError, ExecutionAbortedError) as error:
            self._wait_for_rest(error)
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            self.whole.fail(error)

    def _wait_for_rest(self, error: ExpectedError) -> None:
        if self._overtaken:
            self.whole.fail(CanceledError("another motion has taken the place of this one"))
            return
        rest = rest_of_joints(self._states, self._names)

        def end() -> None:
            moving = rest.result()
            if moving:
                said = f"{error.message}; that the joints have stopped couldn't be confirmed: {moving}"
                self.whole.fail(type(error)(said, **{**error.data, "stopped": False}))
            else:
                self.whole.fail(error)

        rest.add_done_callback(end)
