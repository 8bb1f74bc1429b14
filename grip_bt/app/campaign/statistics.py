"""What results say: rates with their intervals, levels of factors compared, why trials failed; as data.

Intervals of rates are Wilson's, 95 % (Wilson, Probable Inference, JASA 22, 1927). Two levels of a factor, or variants,
are compared by McNemar's exact test on the pairs of trials that differ in nothing else: same seed, same other levels
(McNemar, Psychometrika 12, 1947); where a design has no such pairs, by Fisher's exact test. Of all pairs of one factor,
p is corrected by Holm's method (Holm, A Simple Sequentially Rejective Multiple Test Procedure, 1979).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from math import comb, sqrt
from statistics import NormalDist, median
from typing import Any

from grip_bt.app.campaign.file import Plain
from grip_bt.app.campaign.results import Results, TrialRow

_CONFIDENCE = 0.95
_SPREAD = NormalDist().inv_cdf((1 + _CONFIDENCE) / 2)


def summary(results: Results) -> dict[str, Any]:
    """Return what results say, as JSON data.

    Returns:
        `campaign`, `trials`; `variants`: name -> `trials`, `successes`, `false_successes` (contradicted),
        `rate`, `interval` (low, high), `duration` and `wall` (median, longest [s]), `measures` (name -> median, least,
        most, or how many are true), `failures` (reason -> how often); `factors`: factor -> level -> the same, all
        trials of that level together; `compared`: factor, or `variant` without factors -> pairs of levels, each with
        `first`, `second`, `test`, `only_first`, `only_second` (in how many pairs only that one succeeded), `p`, `holm`;
        `repeated`: trials that were run again, -> the same, or in what they differ; `made`: what trials were made with,
        name -> words.
    """
    by_variant: dict[str, list[TrialRow]] = {name: [] for name in results.head["variants"]}
    for row in results.rows:
        by_variant.setdefault(row["variant"], []).append(row)
    factors: dict[str, dict[str, list[TrialRow]]] = {}
    for name, settings in results.head["variants"].items():
        for factor, level in settings.get("levels", {}).items() if by_variant[name] else ():
            factors.setdefault(factor, {}).setdefault(level, []).extend(by_variant[name])
    compared = factors or {"variant": {name: rows for name, rows in by_variant.items() if rows}}
    told = {name for row in results.rows for name in row.get("provenance", {})}
    made = {name: {row.get("provenance", {}).get(name, "") for row in results.rows} for name in sorted(told)}
    return {
        "campaign": results.head["name"],
        "trials": len(results.rows),
        "variants": {name: _one(rows) for name, rows in by_variant.items() if rows},
        "factors": {name: {level: _one(rows) for level, rows in levels.items()} for name, levels in factors.items()},
        "compared": {name: _pairs(name, levels) for name, levels in compared.items()},
        "repeated": {row["trial"]: row["repeated"] for row in results.rows if row.get("repeated")},
        "made": {name: sorted(words) for name, words in made.items()},
    }


def _one(rows: Sequence[TrialRow]) -> dict[str, Any]:
    good = sum(row["success"] for row in rows)
    low, high = wilson(good, len(rows))
    measures: dict[str, list[Plain]] = {}
    for row in rows:
        for name, value in {**row["counts"], **row["measures"]}.items():
            measures.setdefault(name, []).append(value)
    unclear = [f"{name}: {why}" for row in rows for name, why in row["unclear"].items()]
    return {
        "trials": len(rows),
        "successes": good,
        "false_successes": sum(bool(row.get("contradicted")) for row in rows),
        "rate": good / len(rows),
        "interval": [round(low, 4), round(high, 4)],
        "duration": _times(row["duration"] for row in rows),
        "wall": _times(row["wall"] for row in rows),
        "measures": {name: _measure(values) for name, values in measures.items()},
        "failures": dict(Counter(reason(row) for row in rows if not row["success"]).most_common()),
        "unclear": dict(Counter(unclear).most_common()),
    }


def reason(row: TrialRow) -> str:
    """Return why a trial isn't a success, in a word or two."""
    if row["status"] in ("error", "timed_out"):
        lines = row["message"].strip().splitlines() or ["no message"]
        rest = f"; {row['unconfirmed']}" if row.get("unconfirmed") else ""
        return f"{row['status']}: {lines[-1] if lines[0].startswith('Traceback') else lines[0]}{rest}"
    if row.get("contradicted"):
        return f"ended as {row['outcome']}, which the referee contradicts"
    if row["status"] == "success":
        return f"ended as {row['outcome']}, but the campaign's condition is false"
    return f"{row['outcome']}.{row['code']}" if row["code"] else f"{row['outcome']}"


def wilson(good: int, of: int) -> tuple[float, float]:
    """Return within what a rate lies, at 95 % (Wilson 1927)."""
    squared = _SPREAD**2
    middle, spread = good + squared / 2, _SPREAD * sqrt(good * (of - good) / of + squared / 4)
    return max(0.0, (middle - spread) / (of + squared)), min(1.0, (middle + spread) / (of + squared))


def _times(values: Iterable[float | None]) -> dict[str, float] | None:
    given = [value for value in values if value is not None]
    return {"median": round(median(given), 3), "longest": round(max(given), 3)} if given else None


def _measure(values: Sequence[Plain]) -> dict[str, Any]:
    given = [value for value in values if value is not None]
    if given and all(isinstance(value, bool) for value in given):
        return {"of": len(given), "true": sum(given)}
    numbers = [value for value in given if isinstance(value, int | float) and not isinstance(value, bool)]
    if numbers and len(numbers) == len(given):
        return {"of": len(given), "median": median(numbers), "least": min(numbers), "most": max(numbers)}
    return {"of": len(given), "values": dict(Counter(map(str, given)).most_common(5))}


def _pairs(factor: str, levels: Mapping[str, Sequence[TrialRow]]) -> list[dict[str, Any]]:
    found = [_compared(factor, one, levels[one], two, levels[two]) for one, two in combinations(levels, 2)]
    least = 0.0
    for k, pair in enumerate(sorted(found, key=lambda pair: pair["p"])):
        least = max(least, min(1.0, (len(found) - k) * pair["p"]))
        pair["holm"] = least
    return found


def _compared(factor: str, one: str, first: Sequence[TrialRow], two: str, second: Sequence[TrialRow]) -> dict[str, Any]:
    """Return how two levels compare, on pairs where there are some."""

    def others(row: TrialRow) -> tuple[object, ...]:
        return row["seed"], *(level for name, level in row.get("levels", {}).items() if name != factor)

    good = [{others(row): row["success"] for row in rows} for rows in (first, second)]
    common = good[0].keys() & good[1].keys()
    if not common:
        a, b = sum(row["success"] for row in first), sum(row["success"] for row in second)
        p = fisher(a, len(first), b, len(second))
        return {"first": one, "second": two, "test": "Fisher", "pairs": 0, "only_first": a, "only_second": b, "p": p}
    only = [sum(good[k][each] and not good[1 - k][each] for each in common) for k in (0, 1)]
    words = {"first": one, "second": two, "test": "McNemar", "pairs": len(common)}
    return {**words, "only_first": only[0], "only_second": only[1], "p": mcnemar(*only)}


def mcnemar(one: int, other: int) -> float:
    """Return how likely pairs are that differ so unevenly, or more, where both are as good (exact, two-sided)."""
    ways: int = sum(comb(one + other, k) for k in range(min(one, other) + 1))
    return min(1.0, float(2 * ways / 2 ** (one + other)))


def fisher(good: int, of: int, other_good: int, other_of: int) -> float:
    """Return how likely two rates are that differ by this much, or more, where both are as good (exact, two-sided)."""
    total = good + other_good
    ways = {k: comb(of, k) * comb(other_of, total - k) for k in range(max(0, total - other_of), min(of, total) + 1)}
    return sum(way for way in ways.values() if way <= ways[good]) / sum(ways.values())
