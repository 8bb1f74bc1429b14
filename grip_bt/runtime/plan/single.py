"""The tick of one behaviour that stands alone, such as a state of a machine: one function for a leaf of ours."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .emit_ours import PRELUDE, emit_leaf, plain
from .kinds import Kind, kind_of, ours, overrides
from .parts import INVALID, VALID, F, R, S, rejected
from .plan import Plan
from .regions import code_of
from .writer import Writer


def ticker(node: Any) -> Callable[[], object]:
    """Return what does `node.tick_once()`; nobody may replace methods of the nodes or edit them from now on."""
    if kind_of(node) is not Kind.LEAF or not ours(node) or not plain(node):
        return Plan(node, fixed_methods=True).tick
    write = Writer()
    write.names.update(PRELUDE, S=S, F=F, R=R, I=INVALID, VALID=VALID, rejected=rejected)
    emit_leaf(write, write.bind("n", node), overrides(node, "initialise"), overrides(node, "terminate"))
    lines = [f"def make({', '.join(write.names)}):", "def tick(S=S, F=F, R=R, I=I):", *write.lines, "return tick"]
    made: dict[str, Any] = {}
    exec(code_of("\n ".join(lines), (type(node),)), made)
    tick: Callable[[], object] = made["make"](**write.names)
    return tick
