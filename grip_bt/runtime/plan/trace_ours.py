"""Traces through nodes of ours: what of their ticks is left while nothing changes, and which of them have such ticks.

While a node of ours and its children run on, no activation begins or ends, so that nobody is told of anything. A guard
looks at its condition, a timeout at the clock, both before the child; a parallel whose children's ends are as they were
decides as it did.
"""

from __future__ import annotations

from typing import Any

from grip_bt.nodes import control
from grip_bt.nodes.control.chooser import Chooser
from grip_bt.nodes.control.dispatch import Dispatch
from grip_bt.nodes.control.guard import Guard
from grip_bt.nodes.control.parallel import Parallel

from .kinds import Kind, replaced_on
from .writer import Writer

_WAITING = {cls.update for cls in (control.Retry, control.Repeat, control.Invert, control.Force, control.Subtask)}
"""Updates of our decorators that do nothing but return RUNNING while the child runs."""
_GATES = {(cls.open, cls.update) for cls in (Guard, control.Timeout)}


def stays(node: Any, kind: Kind) -> bool:
    """Tell whether a running container of ours does nothing but tick its running children, or what is written below."""
    cls: Any = type(node)
    if any(replaced_on(node, name) for name in ("update", "follow", "settle", "open") if hasattr(node, name)):
        return False
    match kind:
        case Kind.SEQUENCE | Kind.SELECTOR:
            return bool(node.memory)
        case Kind.DECORATOR:
            return cls.update in _WAITING
        case Kind.GATE:
            return (cls.open, cls.update) in _GATES
        case Kind.ROUNDS:
            return cls.settle is Parallel.settle and cls.ends is Parallel.ends
        case Kind.STEPS:
            return cls.follow is Dispatch.follow
        case Kind.TURNS:
            return cls.follow is Chooser.follow
    return False


def watches_time(node: Any) -> bool:
    """Tell whether the node looks at the clock after its child was ticked."""
    return isinstance(node, control.Timeout) and node.child_first


def emit_deadline(write: Writer, name: str, at: int) -> None:
    """Write that the trace is left where the time is over."""
    write(f"if {name}.over(): return missed({at})")
