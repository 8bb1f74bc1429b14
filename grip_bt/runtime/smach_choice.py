"""SMACH states and containers that behave as a task's: they ask a kind who is next, and answer preempt requests."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

from grip_bt import smach_compat
from grip_bt.base.errors import DataError
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.task_machine import Decide
from grip_bt.nodes.answers import Answers
from grip_bt.runtime.smach_states import TreeRun
from grip_bt.smach_compat import Iterator, State
from grip_bt.task.kinds.base import Kind
from grip_bt.task.model import KINDS
from grip_bt.task.parts import Edges


class Choose(Decide):
    """Asks a kind what follows; ends with `do CHILD`, `success`, or `failure`.

    Its machine begins with it; a loop's child leads back to it. Register `begin` as a start callback of the machine.

    Args:
        node: a `switch` or `loop` as a task file has it, without its children; expressions are over userdata.
        children: names of what it chooses among.
        place: its path in messages.
        codes: failure codes with outcomes of their own, such as `failure.loop_limit`.
    """

    def __init__(
        self,
        run: TreeRun,
        node: Mapping[str, Any],
        children: Sequence[str],
        *,
        place: str = "/",
        codes: Collection[str] = (),
    ):
        refined: Refined = [(outcome, code) for outcome, _, code in (code.partition(".") for code in codes)]
        ends, answers = {label: label for label in ("success", "failure")}, Answers(place, children, Edges(), Edges())
        kind: Kind = KINDS[node["kind"]].model_construct(**node)
        said = {key: parse_expression(text) for key in (*kind.values, *kind.conditions) if (text := getattr(kind, key))}
        names = dict.fromkeys(name for expression in said.values() for name in expression.names)
        super().__init__(kind, answers, ends, run.shared, refined, list(names))
        for key, expression in said.items():
            readers = self._readers(expression, key)
            if key in kind.values:
                answers.readers[key] = value_of(expression, readers)
            else:
                answers.conditions[key] = condition_of(expression, readers)
        self._userdata: Any = None

    def execute(self, userdata: Any) -> str:
        self._userdata = userdata
        return super().execute(userdata)

    def _readers(self, expression: Expression, key: str) -> dict[str, Callable[[], Any]]:
        def reader(name: str) -> Callable[[], Any]:
            def read() -> Any:
                if name not in self._userdata:
                    raise DataError(self.answers.path, key, f"variable {name!r} was read before it was written")
                return self._userdata[name]

            return read

        return {name: reader(name) for name in expression.names}


class Each(Iterator):
    """An Iterator that goes on with its items when a preempt is requested; its state sees the request.

    A stop of the run is seen before each item, and where there is none.
    """

    def __init__(self, run: TreeRun, **said: Any):
        super().__init__(**said)
        self.run = run

    def _loop(self, items: Iterable[object]) -> Any:
        state = self._state
        assert state is not None, "a state is contained"
        self.run.shared.turn()
        for item in items:
            if smach_compat.is_shutdown():
                break
            self.userdata[self._items_label] = item
            asked = self.preempt_requested()
            if asked and not state.preempt_requested():
                state.request_preempt()
            outcome = self._execute_state()
            if self.preempt_requested():
                # a state that has dealt with the request has dealt with it for all of us
                (state if state.preempt_requested() else self).recall_preempt()
            if self._breaks(outcome):
                return outcome
            self.call_transition_cbs()
            self.run.shared.turn()
        return self._exhausted_outcome

    def request_preempt(self) -> None:
        """Ask, and the state too while it is executed."""
        State.request_preempt(self)
        if self._is_running and self._state is not None:
            self._state.request_preempt()
