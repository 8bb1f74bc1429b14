"""What functions and coroutines return, as ends of their leaves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .leaf import Leaf, Status


class End:
    """How a function ends that has outcomes of its own: `return End("heavy", weight=3.2)`.

    Args:
        outcome: one of those that were declared.
        code: of a failure, for `on: {failure.<code>: ...}`.
        message: of a failure, a sentence for people.
        **outputs: output port -> value.
    """

    def __init__(self, outcome: str, /, *, code: str = "", message: str = "", **outputs: Any):
        self.outcome, self.code, self.message, self.outputs = outcome, code, message, outputs


def finish(leaf: Leaf, result: Any, labelled: bool) -> Status:
    """End an activation with what its code has returned.

    Args:
        leaf: whose.
        result: an `End`; else the one output, a mapping of several, or anything where there is none.
        labelled: whether it has outcomes of its own, so that it has to be an `End`.

    Raises:
        TypeError: it doesn't fit; it says what would.
    """
    face, names = leaf.manifest.id, list(leaf.manifest.outputs)
    if isinstance(result, End):
        if result.code:
            return leaf.fail(result.code, result.message, outcome=result.outcome, outputs=result.outputs)
        return leaf.end(result.outcome, **result.outputs)
    if labelled:
        raise TypeError(f"{face} has outcomes of its own: return End('outcome', ...), not {result!r}")
    if not names:
        return leaf.end()
    if len(names) == 1:
        return leaf.end(**{names[0]: result})
    if not isinstance(result, Mapping) or set(result) != set(names):
        raise TypeError(f"{face} has several outputs: return a mapping with the keys {names}")
    return leaf.end(**result)
