"""The state of a machine that asks a rule who is next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.base.errors import NodeError
from grip_bt.nodes.control import Rule
from grip_bt.smach_compat import State

from .behaviour_state import MachineRun, Refined, TaskState, label, labels


class Choice(TaskState):
    """Asks a rule; its outcomes are `do CHILD`, `success`, and `failure` with the codes that need a label.

    Args:
        path: the container's path.
        rule: what is asked.
        children: the children's names.
        run: what the machine's states share.
        refined: (`failure`, code) pairs that have a label of their own.
    """

    def __init__(self, path: str, rule: Rule, children: list[str], run: MachineRun, refined: Refined):
        State.__init__(self, [*(f"do {child}" for child in children), *labels(("success", "failure"), refined)])
        self.path, self.rule, self.run, self.refined = path, rule, run, frozenset(refined)

    def leads(self, ways: Mapping[str, str]) -> dict[str, str]:
        """Return the transitions to the children, given the labels of their states."""
        return {f"do {child}": state for child, state in ways.items()}

    def ends(self) -> list[str]:
        """Return the outcomes that end the container; each has the name of the container's."""
        return labels(("success", "failure"), self.refined)

    def execute(self, userdata: Any) -> str:
        """Ask; a stop is seen here too, since a loop may find nothing to tick."""
        try:
            self.run.turn()
            turn = self.rule.choose()
        except Exception as error:
            wrapped = NodeError(self.path, error)
            self.run.fail(wrapped)
            raise wrapped from error
        self.outcome, self.failure = turn.outcome, turn.failure
        return f"do {turn.child}" if turn.child is not None else label(turn.outcome, turn.failure, self.refined)
