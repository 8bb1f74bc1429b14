"""When it makes a difference that values go in and out of a subtask at once, and not one by one.

A part of a task reads and writes the variables around it while it runs. As a subtask it gets its inputs on entry and
hands out its outputs when it ends, and nothing at all when it is halted. Nobody can tell, unless something may halt it
or runs beside it.
"""

from __future__ import annotations

from collections.abc import Iterator

from grip_bt.base.errors import HandoverError, listing
from grip_bt.task.model import Fallback, Guard, Parallel, Sequence, Switch, Timeout
from grip_bt.task.validation.survey import Spot


def expect_nobody_can_tell(spot: Spot, reads: set[str], writes: set[str]) -> None:
    """Refuse values that go in and out at another moment where something around a node could notice.

    Args:
        spot: the node.
        reads: variables around it that it reads.
        writes: variables around it that it writes.

    Raises:
        HandoverError: it could; the message names what, and where.
    """
    fix = "take all of that container, or say `approximate: true`"
    for around, inside in _interrupting(spot):
        kind = around.node.kind  # type: ignore[union-attr]
        if writes:
            raise HandoverError(
                spot.path,
                f"it writes {listing(sorted(writes))}, and the {kind} {around.path} may halt it, after which a subtask "
                f"hands nothing out; {fix}",
            )
        beside = 0
        for child in around.children.values():
            beside |= 0 if child is inside else child.writes
        changed = [name for name in sorted(reads) if name in spot.around and spot.around[name].bit & beside]
        if changed:
            raise HandoverError(
                spot.path,
                f"it reads {listing(changed)}, which another child of the {kind} {around.path} may write while it runs,"
                f" and a subtask gets its inputs on entry; {fix}",
            )


def _interrupting(spot: Spot) -> Iterator[tuple[Spot, Spot]]:
    """Yield the containers above a node that may halt it or run something beside it, with their child above it."""
    inside, around = spot, spot.parent
    while around is not None:
        node = around.node
        reactive = isinstance(node, Sequence | Fallback | Switch) and not node.memory
        if reactive or isinstance(node, Parallel | Timeout | Guard):
            yield around, inside
        inside, around = around, around.parent
