"""`grip bench`: a campaign of trials, several at once; and what came of it."""

from __future__ import annotations

import argparse
import json
import sys
import time
from datetime import timedelta
from pathlib import Path

from grip_bt.app.campaign.cluster import run_on
from grip_bt.app.campaign.file import Campaign, head_of, read_campaign
from grip_bt.app.campaign.report import as_csv, as_text, write_report
from grip_bt.app.campaign.results import Results, TrialRow, alone, begin, difference, read
from grip_bt.app.campaign.statistics import reason, summary, wilson
from grip_bt.app.campaign.trials import Trials, check
from grip_bt.app.project.folder import Project, find_project
from grip_bt.base.errors import NotWritableError, nearest, plural
from grip_bt.cli import STOPPED, terminal
from grip_bt.cli.parser import add_no_code, whole
from grip_bt.cli.signals import on_stop


def add_bench(parser: argparse.ArgumentParser) -> None:
    parser.usage = (
        "grip bench CAMPAIGN [--workers N] [--cluster [ADDRESS]] [--resume] [--fresh] [--pictures [VIEW]] [-o FILE]\n"
        "       grip bench CAMPAIGN --trial ID\n"
        "       grip bench report RESULTS [--json | --csv] [-o FILE.html|.tex|.parquet|.csv|.json|.md]"
    )
    parser.add_argument("what", nargs="+", metavar="CAMPAIGN", help="the campaign's file; or `report` and its results")
    trials = whole(1, what="a number of trials")
    parser.add_argument("--workers", type=trials, metavar="N", help="trials at a time (default: 1; all of a cluster's)")
    doc = "run trials on a cluster of Ray: this machine's, or the one whose head has this address (HOST:6379)"
    parser.add_argument("--cluster", nargs="?", const="auto", metavar="ADDRESS", help=doc)
    parser.add_argument("--resume", action="store_true", help="keep existing results and run only the missing trials")
    parser.add_argument("--fresh", action="store_true", help="start simulator, planner and components for every trial")
    parser.add_argument("--trial", metavar="ID", help="run one trial again, such as tree@3, and compare it; no results")
    doc = (
        "take a picture of each trial's end, for the report's page: by the world's first camera, or as --view of `run`"
    )
    parser.add_argument("--pictures", nargs="?", const="", metavar="VIEW", help=doc)
    results = "results (default: .grip/campaigns/NAME.jsonl of the project); of a report, where it is written"
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
        results = read(Path(args.what[1]))
        if args.output is None:
            _print(results, args)
        else:
            write_report(results, args.output)
        return 0
    if len(args.what) != 1:
        args.usage_error("one campaign at a time: grip bench CAMPAIGN")
    return _run(Path(args.what[0]), args)


def _run(path: Path, args: argparse.Namespace) -> int:
    campaign = read_campaign(path)
    check(campaign)
    first = next(iter(campaign.file.variants))
    file = args.output or _own_folder(find_project(campaign.task(first))) / "campaigns" / f"{campaign.name}.jsonl"
    if args.trial is not None:
        return _again(campaign, file, args.trial)
    with alone(file), terminal.Bar("trials") as bar:
        return _run_all(campaign, file, args, bar)


def _run_all(campaign: Campaign, file: Path, args: argparse.Namespace, bar: terminal.Bar) -> int:
    results = begin(file, head_of(campaign), args.resume)
    done = results.done
    left = [trial for trial in campaign.trials() if trial not in done]

    def say(text: str) -> None:
        if not (args.json or args.csv or terminal.quiet):
            print(text, file=sys.stderr, flush=True)

    say(_opening(campaign, results, len(left), args.workers or (0 if args.cluster else 1)))
    bar(0, len(left))
    began, before = time.monotonic(), len(results.rows)

    def ended(row: TrialRow) -> None:
        results.add(row)
        passed, done = time.monotonic() - began, len(results.rows) - before
        same = [each for each in results.rows if each["variant"] == row["variant"]]
        low, high = wilson(sum(each["success"] for each in same), len(same))
        rate = f"{row['variant']} {low:.0%} to {high:.0%}"
        say(f"{_line(row, len(results.rows))}; {rate}; {timedelta(seconds=round(passed / done * trials.left))} left")
        bar(done, len(left), row["trial"])

    trials = Trials(
        campaign, file.with_suffix(".sqlite"), ended, before=results.rows, fresh=args.fresh, view=args.pictures
    )
    on_stop(trials.stop)
    if args.cluster:
        run_on(args.cluster, campaign, trials, left, args.workers)
    else:
        trials.run(left, args.workers or 1)
    say(f"\n{time.monotonic() - began:.0f} s; results in {file}\n")
    if results.rows:
        _print(results, args)
    if trials.stopped:
        total = before + len(left)
        say(f"\nstopped: {total - len(results.rows)} of {total} trials are left; --resume runs them")
        return STOPPED
    return 0


def _again(campaign: Campaign, file: Path, trial: str) -> int:
    """Run one trial again, and say whether it went as its results say."""
    names = {f"{variant}@{seed}": (variant, seed) for variant, seed in campaign.trials()}
    if trial not in names:
        raise campaign.error(f"no trial {trial!r}{nearest(trial, names)}; they are called VARIANT@SEED")
    journal = file.with_suffix(".sqlite")
    trials = Trials(campaign, journal, lambda row: None)
    on_stop(trials.stop)
    row = trials.once(*names[trial])
    if row is None:
        return STOPPED
    print(f"{_line(row)}, run {row['run']}")
    rows = read(file).rows if file.exists() else []
    for before in (each for each in rows if (each["variant"], each["seed"]) == names[trial]):
        differs = difference(journal, before["run"], row["run"])
        print(f"  {differs or 'the same as in the results, event by event'}")
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
    variants, seeds = plural(len(campaign.file.variants), "variant"), plural(len(campaign.seeds), "seed")
    return (
        f"{campaign.name}: {variants} on {seeds}{kept}; {plural(left, 'trial')} to run, "
        f"{f'{workers} at a time' if workers else 'as many at a time as the cluster takes'}"
    )


def _line(row: TrialRow, number: int = 0) -> str:
    how = "success" if row["success"] else reason(row)
    again = f"; again in new processes: {row['repeated']}" if row.get("repeated") else ""
    return f"  {f'{number}  ' if number else ''}{row['trial']}: {how}; {row['wall']:.1f} s{again}"


def _print(results: Results, args: argparse.Namespace) -> None:
    if args.json:
        print(json.dumps(summary(results)))
    elif args.csv:
        print(as_csv(results), end="")
    else:
        print(as_text(results))
