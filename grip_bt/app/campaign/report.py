"""What results say: rates with their intervals, comparisons seed by seed, why trials failed; as text, CSV or data.

Intervals of rates are Wilson's, 95 % (Wilson, Probable Inference, JASA 22, 1927). Two variants that met the same seeds
are compared by McNemar's exact test on the seeds in which only one of them succeeded (McNemar, Psychometrika 12, 1947).
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import comb, sqrt
from statistics import NormalDist, median
from typing import Any

from grip_bt.app.campaign.file import Plain, Results, TrialRow

_CONFIDENCE = 0.95
_SPREAD = NormalDist().inv_cdf((1 + _CONFIDENCE) / 2)


def summary(results: Results) -> dict[str, Any]:
    """Return what results say, as JSON data.

    Returns:
        `campaign`, `trials`; `variants`: name -> `trials`, `successes`, `false_successes` (contradicted),
        `rate`, `interval` (low, high), `duration` and `wall` (median, longest [s]), `measures` (name -> median, least,
        most, or how many are true), `failures` (reason -> how often); `compared`: name -> `seeds` in common,
        `only_this`, `only_first`, `p`, against the first variant.
    """
    by_variant: dict[str, list[TrialRow]] = {name: [] for name in results.head["variants"]}
    for row in results.rows:
        by_variant.setdefault(row["variant"], []).append(row)
    names, run = list(by_variant), {name for name, rows in by_variant.items() if rows}
    others = [name for name in names[1:] if {name, names[0]} <= run]
    compared = {name: _compared(by_variant[names[0]], by_variant[name]) for name in others}
    return {
        "campaign": results.head["name"],
        "trials": len(results.rows),
        "variants": {name: _one(rows) for name, rows in by_variant.items() if rows},
        "compared": compared,
    }


def _one(rows: Sequence[TrialRow]) -> dict[str, Any]:
    good = sum(row["success"] for row in rows)
    low, high = _interval(good, len(rows))
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


def _interval(good: int, of: int) -> tuple[float, float]:
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


def _compared(first: Sequence[TrialRow], other: Sequence[TrialRow]) -> dict[str, Any]:
    firsts = {row["seed"]: row["success"] for row in first}
    others = {row["seed"]: row["success"] for row in other}
    common = firsts.keys() & others.keys()
    only_this = sum(others[seed] and not firsts[seed] for seed in common)
    only_first = sum(firsts[seed] and not others[seed] for seed in common)
    differ = only_this + only_first  # the sign test, exact: how likely is this much, or more, of a fair coin?
    p = min(1.0, 2 * sum(comb(differ, k) for k in range(min(only_this, only_first) + 1)) / 2**differ)
    return {"seeds": len(common), "only_this": only_this, "only_first": only_first, "p": round(p, 4)}


def as_text(results: Results) -> str:
    """Return what results say, as Markdown that reads well on a terminal too."""
    said = summary(results)
    lines = [f"# {said['campaign']}", ""]
    lines += [results.head["doc"], ""] if results.head.get("doc") else []
    measures = list(dict.fromkeys(name for one in said["variants"].values() for name in one["measures"]))
    rows = [["variant", "success", "95 %", "false successes", *measures, "run's clock [s]", "wall [s]"]]
    for name, one in said["variants"].items():
        low, high = one["interval"]
        rate = f"{one['successes']} of {one['trials']} ({one['rate']:.0%})"
        cells = [rate, f"{low:.0%} to {high:.0%}", str(one["false_successes"])]
        cells += [_measure_text(one["measures"].get(measure)) for measure in measures]
        rows.append([name, *cells, _time_text(one["duration"]), _time_text(one["wall"])])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    table = [f"| {' | '.join(c.ljust(w) for c, w in zip(row, widths, strict=True))} |" for row in rows]
    lines += [table[0], f"|{'|'.join('-' * (width + 2) for width in widths)}|", *table[1:]]
    first = next(iter(said["variants"]), "")
    lines += [line for name, found in said["compared"].items() for line in ("", _comparison_text(name, first, found))]
    for name, one in said["variants"].items():
        for said_of, found in (("successful", one["failures"]), ("computed", one["unclear"])):
            if found:
                lines += ["", f"{name}, not {said_of}:", *(f"  {count:>3}x {why}" for why, count in found.items())]
    return "\n".join(lines)


def _comparison_text(name: str, first: str, compared: Mapping[str, Any]) -> str:
    if not compared["only_this"] + compared["only_first"]:
        return f"{name} and {first}: the same on all {compared['seeds']} seeds."
    verdict = "a difference" if compared["p"] < 1 - _CONFIDENCE else "no difference that these seeds show"
    return (
        f"{name} against {first}, {compared['seeds']} seeds: only {name} in {compared['only_this']}, only {first} in"
        f" {compared['only_first']} (McNemar, p = {compared['p']:.3f}: {verdict})."
    )


def _measure_text(measure: Mapping[str, Any] | None) -> str:
    if measure is None or not measure["of"]:
        return "-"
    if "true" in measure:
        return f"{measure['true']} of {measure['of']}"
    if "median" in measure:
        spread = "" if measure["least"] == measure["most"] else f" ({measure['least']:g} to {measure['most']:g})"
        return f"{measure['median']:g}{spread}"
    return ", ".join(f"{value} ({count})" for value, count in measure["values"].items())


def _time_text(times: Mapping[str, float] | None) -> str:
    return "-" if times is None else f"{times['median']:.1f} (longest {times['longest']:.1f})"


def as_csv(results: Results) -> str:
    """Return a line a trial, for spreadsheets and data frames."""
    extra = list(dict.fromkeys(name for row in results.rows for name in {**row["counts"], **row["measures"]}))
    known = "variant seed success contradicted status outcome code message duration wall run unconfirmed".split()
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*known, *extra, "truth"])
    for row in results.rows:
        values = {**row["counts"], **row["measures"]}
        truth = " ".join(f"{name}={state}" for name, state in (row["truth"] or {}).items())
        writer.writerow([*(row.get(key) for key in known), *(values.get(name) for name in extra), truth])
    return out.getvalue()
