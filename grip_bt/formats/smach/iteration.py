"""Iterator -> a state machine that takes the next item, runs the contained state, and goes round."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any

from .concurrence import RefusedError
from .found import FoundContainer, Opaque
from .keys import plain_literal

MOST_ITEMS = 10_000
"""Of a range; they stand in the task one by one."""


@dataclass(frozen=True)
class Iteration:
    """What an Iterator does.

    Attributes:
        items: what is iterated over.
        label: userdata that holds the item.
        loops: outcomes of the contained state after which the next item comes.
        final: every other outcome of the contained state -> outcome of the Iterator.
        mapped: its `final_outcome_map`.
        exhausted: outcome of the Iterator after the last item.
    """

    items: list[Any]
    label: str
    loops: frozenset[str]
    final: dict[str, str]
    exhausted: str
    mapped: dict[str, str]

    def interrupted(self) -> list[tuple[str, list[str]]]:
        """Return what it ends with when it is preempted in an item, and after which outcomes of the contained state.

        That may be none of its outcomes.
        """
        result: dict[str, list[str]] = {}
        for outcome in sorted(self.loops):
            result.setdefault(self.mapped.get(outcome, outcome), []).append(outcome)
        return list(result.items())


def iteration_of(found: FoundContainer) -> Iteration:
    """Return what an Iterator does.

    Raises:
        RefusedError: it isn't known, or leads nowhere.
    """
    settings = found.settings
    if len(found.added) != 1:
        raise RefusedError("it needs exactly one contained state")
    (added,) = found.added.values()
    try:
        items = plain_literal(_given(settings.get("it", [])))
    except ValueError as error:
        raise RefusedError(f"its items are `{error}`, which only a run knows") from None
    label, exhausted = settings.get("it_label", "it_data"), settings.get("exhausted_outcome", "exhausted")
    loop, leave = settings.get("loop_outcomes") or [], settings.get("break_outcomes") or []
    mapped = settings.get("final_outcome_map") or {}
    known = added.state.outcomes or []
    words = (*loop, *leave, *mapped, *mapped.values(), label, exhausted)
    if not isinstance(items, list) or not all(isinstance(word, str) for word in words):
        raise RefusedError("its items, outcomes or outcome map are known only by a run")
    # upstream's rule: with a break list, the rest loops; without, whatever isn't in the loop list breaks
    loops = frozenset(o for o in known if (o not in leave if leave else o in loop))
    final = {o: mapped.get(o, o) for o in known if o not in loops}
    for target in (*final.values(), mapped.get(exhausted, exhausted)):
        if target not in (found.outcomes or ()):
            raise RefusedError(f"it would end with {target!r}, which is none of its outcomes")
    return Iteration(items, label, loops, final, mapped.get(exhausted, exhausted), dict(mapped))


def _given(items: Any) -> Any:
    """Return items; those of a function that only returns a literal, or a range between literals, are that."""
    if isinstance(items, Opaque) and isinstance(items.expression, ast.Lambda):
        body = items.expression.body
        try:
            return _range(body) if isinstance(body, ast.Call) else ast.literal_eval(body)
        except (TypeError, ValueError):
            return items
    return items


def _range(call: ast.Call) -> list[int]:
    """Return what `range(0, 5)` holds, or `list(range(0, 5))`, also in Python 2's spelling.

    Raises:
        TypeError, ValueError: it is none, none of literals, or longer than a task should be.
    """
    name, given = getattr(call.func, "id", ""), call.args
    if call.keywords:
        raise ValueError(name)
    if name == "list" and len(given) == 1 and isinstance(given[0], ast.Call):
        return _range(given[0])
    if name not in ("range", "xrange"):
        raise ValueError(name)
    items = range(*(ast.literal_eval(argument) for argument in given))
    if len(items) > MOST_ITEMS:
        raise ValueError(name)
    return list(items)
