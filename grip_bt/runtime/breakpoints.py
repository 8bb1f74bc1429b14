"""Where a run is to hold: before or after a node, on an outcome, on a condition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

from grip_bt.base.errors import UnknownNameError
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.probe import parts_of, probe

When = Literal["before", "after"]


@dataclass(frozen=True)
class Breakpoint:
    """One place.

    Attributes:
        id: 1, 2, 3 ...
        node: the node's path.
        when: before an activation begins, or after it has ended.
        outcome: only after this outcome; None for any.
        code: only with this failure code; None for any.
        condition: the text of the condition; empty for none.
        holds: computes the condition; None for none.
        once: it clears itself when the run has come there.
    """

    id: int
    node: str
    when: When
    outcome: str | None = None
    code: str | None = None
    condition: str = ""
    holds: Callable[[], bool] | None = None
    once: bool = False

    def facts(self) -> dict[str, Any]:
        """Return it as the control protocol says it."""
        outcome = self.outcome if self.code is None else f"{self.outcome}.{self.code}"
        return {"id": self.id, "node": self.node, "when": self.when, "outcome": outcome, "if": self.condition or None}

    def __str__(self) -> str:
        outcome = "" if self.outcome is None else f" {self.outcome}" + (f".{self.code}" if self.code else "")
        condition = f" if {self.condition}" if self.condition else ""
        return f"{self.id}: {self.when} {self.node}{outcome}{condition}"


def node_path(text: str) -> str:
    """Return a path as the document spells it: `/a/b` is `a/b`, and `/` is the root."""
    return text.strip().strip("/") or "/"


def make_breakpoint(
    compiled: CompiledTree | CompiledMachine,
    id: int,
    node: str,
    when: str = "",
    outcome: str | None = None,
    condition: str = "",
    once: bool = False,
) -> Breakpoint:
    """Check what a user asked for against the task.

    Args:
        compiled: the task.
        id: the breakpoint's number.
        node: path of the node.
        when: `before` or `after`; by default after where an outcome is given, else before.
        outcome: `outcome` or `outcome.code`.
        condition: an expression over the variables that the node sees.
        once: for a run to a place.

    Raises:
        UnknownNameError: there is no such node, outcome, variable or moment.
        ExpressionError: the condition can't be read.
    """
    parts, path = parts_of(compiled), node_path(node)
    if path not in parts:
        raise UnknownNameError("node", path, parts)
    moment = when or ("after" if outcome else "before")
    if moment not in get_args(When) or (outcome and moment == "before"):
        allowed = ["after"] if outcome else get_args(When)
        raise UnknownNameError("moment", moment, allowed, "a breakpoint" + (" on an outcome" if outcome else ""))
    name, _, code = (outcome or "").partition(".")
    if name and name not in parts[path].meaning:
        raise UnknownNameError("outcome", name, parts[path].meaning, path)
    holds = probe(compiled, parts[path], condition) if condition else None
    return Breakpoint(
        id, path, "before" if moment == "before" else "after", name or None, code or None, condition, holds, once
    )
