"""SMACH states and containers that behave as a task's: they ask a kind who is next, and answer preempt requests."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, Self

from grip_bt import smach_compat
from grip_bt.base.errors import DataError
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.task_machine import Decide
from grip_bt.nodes.answers import Answers
from grip_bt.runtime.smach_states import TreeRun
from grip_bt.smach_compat import Iterator, State
from grip_bt.task.kinds.base import Kind
from grip_bt.task.kinds.loop import Loop
from grip_bt.task.kinds.switch import Switch
from grip_bt.task.parts import Edges


class Choose(Decide):
    """Asks a kind what follows; ends with `do CHILD`, `success`, or `failure`. Made by `case` or `loop`.

    Its machine begins with it; a loop's child leads back to it. Register `begin` as a start callback of the machine.
    """

    def __init__(
        self,
        run: TreeRun,
        kind: Kind,
        names: Collection[str],
        children: Sequence[str],
        place: str,
        codes: Collection[str],
    ):
        refined: Refined = [(outcome, code) for outcome, _, code in (code.partition(".") for code in codes)]
        ends, answers = {label: label for label in ("success", "failure")}, Answers(place, children, Edges(), Edges())
        super().__init__(kind, answers, ends, run.shared, refined, list(names))
        self._userdata: Any = None

    @classmethod
    def case(
        cls,
        run: TreeRun,
        value: str,
        cases: Mapping[str, Sequence[Any]],
        default: str = "",
        *,
        place: str = "/",
        codes: Collection[str] = (),
    ) -> Self:
        """Return the state of a switch; see `Choose.loop` for the rest.

        Args:
            value: an expression over userdata.
            cases: child -> the literals for which it is next.
            default: the child for every other value; without it the state ends with `failure`.
        """
        expression = parse_expression(value)
        children = list(dict.fromkeys([*cases, *([default] if default else [])]))
        kind = Switch.model_construct(
            kind="switch",
            on_value=value,
            cases=FrozenDict({child: list(literals) for child, literals in cases.items()}),
            default=default,
            children=FrozenDict(),
        )
        state = cls(run, kind, expression.names, children, place, codes)
        state.answers.readers["on_value"] = value_of(expression, state._readers(expression, "on_value"))
        return state

    @classmethod
    def loop(
        cls,
        run: TreeRun,
        child: str,
        condition: str = "",
        times: int | None = None,
        *,
        place: str = "/",
        codes: Collection[str] = (),
    ) -> Self:
        """Return the state of a loop; `place` is its path in messages.

        Args:
            child: what is done.
            condition: an expression over userdata: while it is true.
            times: how often at most.
            codes: failure codes with outcomes of their own, such as `failure.loop_limit`.
        """
        expression = parse_expression(condition) if condition else None
        kind = Loop.model_construct(kind="loop", while_=condition, times=times, child=FrozenDict())
        state = cls(run, kind, expression.names if expression else (), [child], place, codes)
        if expression is not None:
            state.answers.conditions["while_"] = condition_of(expression, state._readers(expression, "while"))
        return state

    def execute(self, userdata: Any) -> str:
        """Ask.

        Raises:
            NodeError: the expression can't be computed.
            Halted: the run was stopped.
        """
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
