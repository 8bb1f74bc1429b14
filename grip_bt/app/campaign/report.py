"""Reports of a campaign: text for a terminal, a table for LaTeX, one page for a browser, rows for other programs."""

from __future__ import annotations

import csv
import io
import json
from base64 import b64encode
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from grip_bt.app.campaign.results import Results, picture_of, pictures_of
from grip_bt.app.campaign.statistics import reason, summary
from grip_bt.base.errors import CampaignError, MissingPartError, NotWritableError
from grip_bt.base.types import JsonObject

PER_VARIANT = ("task sha256", "project sha256")
"""What may differ from variant to variant."""
ALPHA = 0.05
"""Significance level: what chance makes less likely than this is called a difference."""


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
    for factor, levels in said["factors"].items():
        lines += ["", f"{factor}:", *(f"  {level}: {_rate_text(one)}" for level, one in levels.items())]
    for pairs in said["compared"].values():
        lines += [line for pair in pairs for line in ("", _comparison_text(pair))]
    if said["repeated"]:
        differ = {trial: words for trial, words in said["repeated"].items() if words != "the same"}
        lines += [
            "",
            f"{len(said['repeated'])} trials were run again in new processes; {len(differ) or 'none'} differed.",
        ]
        lines += [f"  {trial}: {words}" for trial, words in differ.items()]
    for name, words in said["made"].items():
        lines += (
            ["", f"not all with the same {name}: {'; '.join(words)}"]
            if len(words) > 1 and name not in PER_VARIANT
            else []
        )
    for name, one in said["variants"].items():
        for said_of, found in (("successful", one["failures"]), ("computed", one["unclear"])):
            if found:
                lines += ["", f"{name}, not {said_of}:", *(f"  {count:>3}x {why}" for why, count in found.items())]
    return "\n".join(lines)


def _rate_text(one: JsonObject) -> str:
    low, high = one["interval"]
    return f"{one['successes']} of {one['trials']} ({one['rate']:.0%}, {low:.0%} to {high:.0%})"


def _comparison_text(pair: JsonObject) -> str:
    one, two = pair["first"], pair["second"]
    verdict = "a difference" if pair["holm"] < ALPHA else "no difference that these trials show"
    chance = f"{pair['test']}, p = {pair['p']:.3g}, by Holm {pair['holm']:.3g}: {verdict}"
    if not pair["pairs"]:
        return f"{one} and {two}, not in pairs ({chance})."
    if not pair["only_first"] + pair["only_second"]:
        return f"{one} and {two}: the same in all {pair['pairs']} pairs."
    only = f"only {one} in {pair['only_first']}, only {two} in {pair['only_second']}"
    return f"{one} and {two}, {pair['pairs']} pairs: {only} ({chance})."


def _measure_text(measure: JsonObject | None) -> str:
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


KNOWN = "trial variant seed success contradicted status outcome code message duration wall run unconfirmed repeated"


def records(results: Results) -> list[dict[str, Any]]:
    """Return a flat record a trial, all with the same keys: what is known of it, levels, measures, provenance."""
    found = []
    for row in results.rows:
        truth = " ".join(f"{name}={state}" for name, state in (row["truth"] or {}).items())
        known = {key: row.get(key) for key in KNOWN.split()}
        more = {**row.get("levels", {}), **row["counts"], **row["measures"], **row.get("judged", {})}
        found.append({**known, **more, "truth": truth, **row.get("provenance", {})})
    keys = list(dict.fromkeys(key for record in found for key in record))
    return [{key: record.get(key) for key in keys} for record in found]


def as_csv(results: Results) -> str:
    """Return a line a trial, for spreadsheets and data frames."""
    rows, out = records(results), io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]) if rows else KNOWN.split(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def as_latex(results: Results) -> str:
    """Return a table for LaTeX with `booktabs`: rates with their intervals, by factor and level, or by variant."""
    said = summary(results)
    groups = said["factors"] or {"variant": said["variants"]}
    lines = [r"\begin{tabular}{llrrr}", r"\toprule", r" & & trials & success & 95\,\% interval \\"]
    for factor, levels in groups.items():
        lines.append(r"\midrule")
        for level, one in levels.items():
            low, high = (100 * bound for bound in one["interval"])
            shown = rf"{100 * one['rate']:.1f}\,\% & {low:.1f}--{high:.1f}\,\%"
            lines.append(rf"{_escaped(factor)} & {_escaped(level)} & {one['trials']} & {shown} \\")
            factor = ""
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _escaped(text: str) -> str:
    return "".join(f"\\{each}" if each in "&%$#_{}" else each for each in text)


def as_html(results: Results) -> str:
    """Return one page that needs nothing else: plots of rates, of two factors against each other, and all tables."""
    from jinja2 import Environment

    said = summary(results)
    template = Environment(autoescape=True).from_string(Path(__file__).with_name("report.html").read_text("utf-8"))
    axes = list(said["factors"])[:2]
    cells: dict[tuple[str, ...], list[int]] = {}
    for row in results.rows if len(axes) == 2 else ():
        cell = cells.setdefault(tuple(row["levels"][axis] for axis in axes), [0, 0])
        cell[0], cell[1] = cell[0] + row["success"], cell[1] + 1
    groups = said["factors"] or {"variant": said["variants"]}
    known = {"said": said, "groups": groups, "doc": results.head["doc"], "axes": axes, "cells": cells}
    return template.render(**known, rows=records(results), gallery=_gallery(results))


def _gallery(results: Results) -> dict[str, dict[str, tuple[str, int, str]]]:
    """Return, variant by variant, of each way in which trials ended: the first that has a picture, how many, it."""
    found: dict[str, dict[str, tuple[str, int, str]]] = {}
    for row in results.rows:
        file = pictures_of(results.path) / picture_of(row["trial"])
        if not file.is_file():
            continue
        why = "success" if row["success"] else reason(row)
        ways = found.setdefault(row["variant"], {})
        trial, count, shown = ways.get(why) or (row["trial"], 0, b64encode(file.read_bytes()).decode())
        ways[why] = trial, count + 1, shown
    return found


def write_parquet(results: Results, file: Path) -> None:
    """Write a record a trial. Raises MissingPartError where pyarrow isn't installed."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise MissingPartError(f"Parquet ({error})", "pip install 'grip-bt[parquet]'") from None
    parquet.write_table(pyarrow.Table.from_pylist(records(results)), file)


FORMS: Mapping[str, Callable[[Results], str]] = {
    ".txt": as_text,
    ".md": as_text,
    ".csv": as_csv,
    ".json": lambda results: json.dumps(summary(results)),
    ".tex": as_latex,
    ".html": as_html,
}


def write_report(results: Results, file: Path) -> None:
    """Write what results say in the form that the file's ending says.

    Raises:
        CampaignError: there is no such form.
        MissingPartError: what it needs isn't installed.
        NotWritableError: it can't be written there.
    """
    form = FORMS.get(file.suffix)
    if form is None and file.suffix != ".parquet":
        raise CampaignError(str(file), f"reports end in {', '.join((*FORMS, '.parquet'))}")
    try:
        if form is None:
            write_parquet(results, file)
        else:
            file.write_text(form(results), "utf-8")
    except OSError as error:
        raise NotWritableError(file, error, "give another file with -o") from error
