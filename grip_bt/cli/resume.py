"""`grip run --resume` and `--fork`: the words and questions of resuming a run; the run itself is `grip run`'s."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from grip_bt.app.runs.execute import RunOptions
from grip_bt.app.runs.replay import journal_of
from grip_bt.app.runs.resume_plan import (
    Question,
    ResumePlan,
    agree,
    plan_resume,
)
from grip_bt.runtime.control import RunEnd

from .parser import whole


class Given(argparse.Action):
    """Keeps a value, and that the command line gave it: what it doesn't give is as it was in the run."""

    def __call__(
        self, parser: object, namespace: argparse.Namespace, values: object, option: str | None = None
    ) -> None:
        """Keep it."""
        setattr(namespace, self.dest, values)
        namespace.given = getattr(namespace, "given", frozenset()) | {self.dest}


Execute = Callable[["RunOptions"], "tuple[int, RunEnd]"]
"""Runs once, and returns the exit status and the event `ended`."""


def add_resume_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `grip run` that go on with a run."""
    group = parser.add_argument_group("resuming a run")
    either = group.add_mutually_exclusive_group()
    either.add_argument("--resume", metavar="RUN", help="resume a run whose process died; `last` for the last one")
    either.add_argument("--fork", metavar="RUN", help="a new run that continues from event --at of another one")
    group.add_argument("--at", metavar="PLACE", help="with --fork: an event's number, NODE, or NODE:OUTCOME")
    group.add_argument(
        "--set-outcome",
        action="append",
        default=[],
        metavar="NODE=OUTCOME",
        help="force the next outcome of a leaf, such as attempt/grasp=failure.no_ik",
    )
    group.add_argument(
        "--times",
        type=whole(1, what="a number of runs"),
        default=1,
        metavar="N",
        help="with --fork: N runs, with seeds that go up",
    )
    group.add_argument("--yes", action="store_true", help="confirm everything that would be asked")
    parser.add_argument(
        "--durable", action="store_true", help="write the journal to disk before each motion starts and after it ends"
    )


def check_usage(args: argparse.Namespace, error: Callable[[str], object]) -> None:
    """Refuse options that don't go together; `error` ends the process."""
    if args.task is None and not (args.resume or args.fork):
        error("a task file is needed, or --resume RUN, or --fork RUN")
    if bool(args.fork) != bool(args.at):
        error("--fork RUN and --at PLACE go together")
    if args.set_outcome and not (args.resume or args.fork):
        error("--set-outcome goes with --resume or --fork; in a new run, --mock NODE=SCRIPT does that")
    if args.times > 1 and (not args.fork or args.control or args.debug or args.breaks):
        error("--times goes with --fork, without --control, --debug and --break")


def prepare(args: argparse.Namespace, options: RunOptions, given: frozenset[str]) -> ResumePlan:
    """Look at the run, and ask what has to be asked; `given` has the options that the command line really gave."""
    plan = plan_resume(
        journal_of(args.task, args.journal),
        args.resume or args.fork,
        options,
        given,
        at=args.at,
        task=args.task,
        outcomes=args.set_outcome,
        agreed=args.yes,
    )
    for note in plan.notes:
        _say(note)
    if args.yes or args.fork:  # a fork moves nothing that another run has left behind
        for question in plan.questions:
            _say(str(question))
    else:
        agree(plan.questions, _ask if sys.stdin.isatty() else None)
    return plan


def fork_often(plan: ResumePlan, times: int, as_json: bool, execute: Execute) -> int:
    """Run a fork several times, and print how it ended how often; return the worst exit status."""
    ends, worst = [], 0
    for number in range(times):
        status, end = execute(replace(plan.options, seed=plan.options.seed + number))
        ends.append(end)
        worst = max(worst, status)
        if status not in (0, 3, 4):  # nothing was run, or somebody stopped it
            break
    counts = Counter(_how(end) for end in ends)
    if as_json:
        print(json.dumps({"runs": len(ends), "outcomes": dict(counts)}))
    else:
        print(f"{len(ends)} run{'s' if len(ends) != 1 else ''}:")
        for how, count in counts.most_common():
            print(f"  {count:>3}x {how}")
    return worst


def _how(end: RunEnd) -> str:
    said = end.get("outcome") or end.get("status") or end.get("event")
    return f"{said}" + (f" ({end['code']})" if end.get("code") else "")


def _ask(question: Question) -> bool:
    sys.stderr.write(f"{question}. Continue? [y/N] ")
    sys.stderr.flush()
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _say(text: str) -> None:
    print(f"  {text}", file=sys.stderr, flush=True)
