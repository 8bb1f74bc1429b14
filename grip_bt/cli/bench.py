"""`grip bench`: a campaign of trials, several at once; and what came of it."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from grip_bt.app.campaign.file import Campaign, Results, TrialRow, begin, head_of, read, read_campaign
from grip_bt.app.campaign.report import as_csv, as_text, reason, summary
from grip_bt.app.campaign.trials import Trials, check
from grip_bt.app.project.folder import Project, find_project
from grip_bt.base.errors import NotWritableError
from grip_bt.cli import STOPPED
from grip_bt.cli.parser import add_no_code, whole
from grip_bt.cli.terminal import on_stop


def add_bench(parser: argparse.ArgumentParser) -> None:
    parser.usage = (
        "grip bench CAMPAIGN [--workers N] [--resume] [-o FILE]\n       grip bench report RESULTS [--json | --csv]"
    )
    parser.add_argument("what", nargs="+", metavar="CAMPAIGN", help="the campaign's file; or `report` and its results")
    trials = whole(1, what="a number of trials")
    parser.add_argument("--workers", type=trials, default=1, metavar="N", help="trials at a time (default: 1)")
    parser.add_argument("--resume", action="store_true", help="keep existing results and run only the missing trials")
    results = "results (default: .grip/campaigns/NAME.jsonl of the project)"
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help=results)
    add_no_code(parser)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    form.add_argument("--csv", action="store_true", help="print one line per trial")


def run_bench(args: argparse.Namespace) -> int:
    """Run a campaign, or print a report; 0 when every trial was run, whatever came of it."""
    if args.what[0] == "report":
        if len(args.what) != 2:
            args.usage_error("report needs the file of results: grip bench report .grip/campaigns/NAME.jsonl")

        _print(read(Path(args.what[1])), args)
        return 0
    if len(args.what) != 1:
        args.usage_error("one campaign at a time: grip bench CAMPAIGN")
    return _run(Path(args.what[0]), args)


def _run(path: Path, args: argparse.Namespace) -> int:
    campaign = read_campaign(path)
    check(campaign)
    first = next(iter(campaign.file.variants))
    file = args.output or _own_folder(find_project(campaign.task(first))) / "campaigns" / f"{campaign.name}.jsonl"
    results = begin(file, head_of(campaign), args.resume)
    left = [trial for trial in campaign.trials() if trial not in results.done]

    def say(text: str) -> None:
        if not (args.json or args.csv):
            print(text, file=sys.stderr, flush=True)

    say(_opening(campaign, results, len(left), args.workers))
    began, total = time.monotonic(), len(results.done) + len(left)

    def ended(row: TrialRow) -> None:
        results.add(row)
        say(_line(row, len(results.rows), total))

    trials = Trials(campaign, file.with_suffix(".sqlite"), ended)
    on_stop(trials.stop)
    trials.run(left, args.workers)
    say(f"\n{time.monotonic() - began:.0f} s; results in {file}\n")
    if results.rows:
        _print(results, args)
    if trials.stopped:
        say(f"\nstopped: {total - len(results.rows)} of {total} trials are left; --resume runs them")
        return STOPPED
    return 0


def _own_folder(project: Project) -> Path:
    try:
        return project.state_folder
    except NotWritableError as error:
        cause = error.__cause__ if isinstance(error.__cause__, OSError) else OSError(str(error))
        advice = "results are kept there; give another file for them with -o"
        raise NotWritableError(project.folder / ".grip", cause, advice) from error


def _opening(campaign: Campaign, results: Results, left: int, workers: int) -> str:
    kept = f", {len(results.rows)} are there" if results.rows else ""
    ways = len(campaign.file.variants)
    return (
        f"{campaign.name}: {ways} variant{'s' if ways > 1 else ''} on {len(campaign.seeds)} seeds{kept}; "
        f"{left} trials to run, {workers} at a time"
    )


def _line(row: TrialRow, number: int, total: int) -> str:
    how = "success" if row["success"] else reason(row)
    return f"  {number:>{len(str(total))}}/{total}  {row['variant']}, seed {row['seed']}: {how}; {row['wall']:.1f} s"


def _print(results: Results, args: argparse.Namespace) -> None:
    if args.json:
        print(json.dumps(summary(results)))
    elif args.csv:
        print(as_csv(results), end="")
    else:
        print(as_text(results))
