"""Containers of SMACH that answer a preempt request as a task does: what runs sees it, and nothing is left out for it.

SMACH's own Concurrence ends with `preempted` when its children have obeyed, and doesn't tell them of a request that
came before it began; its Iterator leaves the items that are left.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from grip_bt import smach_compat
from grip_bt.smach_compat import Concurrence, Iterator, State

from .tree_state import TreeRun


class Joining(Concurrence):
    """A Concurrence that leaves a preempt request to its children, and ends by its `outcome_cb` all the same."""

    def execute(self, parent_ud: Any = None) -> Any:
        """Bring a request that came before to the children, then execute."""
        if self.preempt_requested():
            self._ask_children()
        return super().execute(parent_ud)

    def request_preempt(self) -> None:
        """Ask every child to stop."""
        State.request_preempt(self)
        self._ask_children()

    def _ask_children(self) -> None:
        for child in self.get_children().values():
            child.request_preempt()


class Each(Iterator):
    """An Iterator that goes on with its items when a preempt is requested; its state sees the request.

    Args:
        run: what the machine's states share: a stop is seen before each item, and where there is none.
        **said: as an Iterator's.
    """

    def __init__(self, run: TreeRun, **said: Any):
        super().__init__(**said)
        self.run = run

    def _loop(self, items: Iterable[Any]) -> Any:
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
                self._taken_back(state)
            if self._breaks(outcome):
                return outcome
            self.call_transition_cbs()
            self.run.shared.turn()
        return self._exhausted_outcome

    def _taken_back(self, state: State) -> None:
        """A state that has dealt with the request has dealt with it for all of us."""
        if state.preempt_requested():
            state.recall_preempt()
        else:
            self.recall_preempt()

    def request_preempt(self) -> None:
        """Ask, and the state too while it is executed."""
        State.request_preempt(self)
        if self._is_running and self._state is not None:
            self._state.request_preempt()
