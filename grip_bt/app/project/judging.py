"""Conditions over what the referee of a simulated world finds: a project's `goals` and a world's `judge`.

They name how many objects are in a state (`held`, `placed`, `fallen`, `standing`, `lying`, `elsewhere`), how many there
are (`objects`), how many have their centre in a region (`in_REGION`), and what is known of articulated objects, such as
`cabinet_opened` [m].
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import get_args

from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, nearest
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_sim.referee import ObjectTruth, Status

STATES: tuple[str, ...] = get_args(Status)
"""What a referee may say of an object."""
Counts = Mapping[str, float]


class WorldCondition:
    """A condition over what is true in a world.

    Args:
        text: the condition.
        regions: names of the world's regions.
        measures: names of what is known of articulated objects.
        where: what to name in errors, such as `goals/pick`.
        file: that it stands in.

    Raises:
        DocumentError: it isn't a condition over these names.
    """

    def __init__(self, text: str, regions: Iterable[str], measures: Iterable[str], where: str, file: str):
        self.text = text
        known = ("objects", *STATES, *(f"in_{region}" for region in regions), *measures)
        self._counts: Counts = dict.fromkeys(known, 0)
        try:
            parsed = parse_expression(text)
            for name in parsed.names:
                if name not in known:
                    near, there = nearest(name, known), ", ".join(known)
                    raise DocumentError(f"{where}: unknown name {name!r}{near} (available: {there})", file)
            self._compute = condition_of(parsed, {name: self._reader(name) for name in parsed.names})
            self._compute()
        except (ExpressionError, EvaluationError) as error:
            raise DocumentError(f"{where}: {error}", file) from error

    def holds(self, counts: Counts) -> bool:
        """Tell whether it is true of what was counted, see `counted`."""
        self._counts = counts
        return self._compute()

    def _reader(self, name: str) -> Callable[[], float]:
        return lambda: self._counts.get(name, 0)


def counted(truth: Iterable[ObjectTruth], regions: Iterable[str], measures: Counts) -> Counts:
    """Return how many objects are in each state and region, how many there are, and the measures."""
    truth = tuple(truth)
    states: Counter[str] = Counter(thing.status for thing in truth)
    inside = Counter(region for thing in truth for region in thing.regions)
    return {
        "objects": len(truth),
        **{state: states[state] for state in STATES},
        **{f"in_{region}": inside[region] for region in regions},
        **measures,
    }
