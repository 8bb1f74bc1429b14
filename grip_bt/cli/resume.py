"""`grip run --resume` and `--fork`: the words and questions of going on with a run; the run itself is `grip run`'s."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.runs.execute import RunOptions, check_task
from grip_bt.app.runs.mocks import apply_mocks
from grip_bt.app.runs.replay import find_run, journal_of
from grip_bt.app.runs.resume import (
    GoOn,
    Question,
    agree,
    place_in,
    questions,
    read_results,
    recorded_options,
    resumable,
    see_off,
    undamaged,
)
from grip_bt.app.runs.saved_state import MESSAGES, unreadable
from grip_bt.base.errors import ResumeError
from grip_bt.compilers.resolve import resolve
from grip_bt.runtime import JournalReader

from .parser import whole


class Given(argparse.Action):
    """Keeps a value, and that the command line gave it: what it doesn't give is as it was in the run."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, values: Any, option: str | None = None) -> None:
        """Keep it."""
        setattr(namespace, self.dest, values)
        namespace.given = getattr(namespace, "given", frozenset()) | {self.dest}


Execute = Callable[["RunOptions"], "tuple[int, Mapping[str, Any]]"]
"""Runs once, and returns the exit status and the event `ended`."""


def add_resume_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `grip run` that go on with a run."""
    group = parser.add_argument_group("going on with a run")
    either = group.add_mutually_exclusive_group()
    either.add_argument("--resume", metavar="RUN", help="go on with a run whose process died; `last` for the last one")
    either.add_argument("--fork", metavar="RUN", help="a new run, which goes on from the event --at of another one")
    group.add_argument("--at", metavar="PLACE", help="with --fork: an event's number, NODE, or NODE:OUTCOME")
    group.add_argument(
        "--set-outcome",
        action="append",
        default=[],
        metavar="NODE=OUTCOME",
        help="how a leaf ends next, in place of its work, such as attempt/grasp=failure.no_ik",
    )
    group.add_argument(
        "--times",
        type=whole(1, what="a number of runs"),
        default=1,
        metavar="N",
        help="with --fork: N runs, with seeds that go up",
    )
    group.add_argument("--yes", action="store_true", help="agree to what would be asked")
    parser.add_argument(
        "--durable", action="store_true", help="no motion begins or ends before the journal on disk says so"
    )


def check_usage(args: argparse.Namespace, error: Callable[[str], Any]) -> None:
    """Refuse options that don't go together; `error` ends the process."""
    if args.task is None and not (args.resume or args.fork):
        error("a task file is needed, or --resume RUN, or --fork RUN")
    if bool(args.fork) != bool(args.at):
        error("--fork RUN and --at PLACE go together")
    if args.set_outcome and not (args.resume or args.fork):
        error("--set-outcome goes with --resume or --fork; in a new run, --mock NODE=SCRIPT does that")
    if args.times > 1 and (not args.fork or args.control or args.debug or args.breaks):
        error("--times goes with --fork, without --control, --debug and --break")


@dataclass(frozen=True)
class Ready:
    """A run that can be gone on with.

    Attributes:
        task: its file.
        options: with which it goes on.
    """

    task: Path
    options: RunOptions


def prepare(args: argparse.Namespace, options: RunOptions, given: frozenset[str]) -> Ready:
    """Look at the run, and ask what has to be asked.

    Args:
        args: of the command line.
        options: of the command line.
        given: the options' names that the command line really gave; for others, those of the run are taken.

    Raises:
        UnknownNameError: there is no such run, place, node or outcome.
        ResumeError: it can't be gone on with; it says what can be done.
    """
    file = journal_of(args.task, args.journal)
    with JournalReader(file) as reader:
        record = reader.run(find_run(reader, args.resume or args.fork))
        known = len(reader.damage)
        events = undamaged(reader, record.id)
        if args.resume and len(reader.damage) > known:
            raise ResumeError(
                f"run {record.id} can't be gone on with, since it is damaged: {'; '.join(reader.damage[known:])}. "
                f"As a new run, from any event up to {len(events)}: grip run --fork {record.id} --at {len(events)}"
            )
    at = None
    if args.fork:
        at = place_in(record, events, args.at)
    else:
        resumable(record, events)
        if record.status == "died":
            with JournalReader(file) as reader:
                see_off(reader, record.id)
    task = _file_of(args.task, record.task_path, file)
    was = recorded_options(events)
    values = dict(options.data)
    options = replace(options, **{k: was[k] for k in was.keys() - given if hasattr(options, k)})
    options = replace(
        options, data=was.get("data", {}), target="sm" if record.target == "sm" else "bt", journal=file.absolute()
    )
    project, document, _ = check_task(task, record.task_text)
    if task.is_file() and task.read_text(encoding="utf-8") != record.task_text:
        _say(f"{task} has changed since; the run goes on with the task as it was")
    catalog, model = catalogue_of(project), document.task
    parts = {part.path: part for part in resolve(model, catalog).root.walk()}
    if options.mocks:
        model, catalog, _ = apply_mocks(model, catalog, options.mocks)
        parts = {part.path: part for part in resolve(model, catalog).root.walk()}
    results = read_results(parts, args.set_outcome)
    happened = events if at is None else events[:at]
    stays = MESSAGES if project.file.message_server and options.robot != "fake" else ""
    with JournalReader(file) as reader:
        anew = unreadable(reader, happened, options.robot, stays) if args.yes or at is None else {}
    go_on = GoOn(record.id, at, results, values, agreed=args.yes or bool(anew))
    asked = questions(parts, happened, go_on, options.mocks, options.robot, stays, anew)
    if args.yes or at is not None:  # a fork moves nothing that another run has left behind
        for question in asked:
            _say(str(question))
    else:
        agree(asked, _ask if sys.stdin.isatty() else None)
    return Ready(task, replace(options, go_on=asdict(go_on)))


def fork_often(ready: Ready, times: int, as_json: bool, execute: Execute) -> int:
    """Run a fork several times, and print how it ended how often; return the worst exit status."""
    ends, worst = [], 0
    for number in range(times):
        status, end = execute(replace(ready.options, seed=ready.options.seed + number))
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


def _how(end: Mapping[str, Any]) -> str:
    said = end.get("outcome") or end.get("status") or end.get("event")
    return f"{said}" + (f" ({end['code']})" if end.get("code") else "")


def _file_of(given: Path | None, recorded: str, journal: Path) -> Path:
    """Return the task's file: the one that is given, or the recorded one, from here or from the project's folder."""
    if given is not None:
        return given
    path = Path(recorded)
    folder = journal.absolute().parent.parent if journal.parent.name == ".grip" else Path.cwd()
    for candidate in (path, folder / path, folder / "tasks" / path.name, folder / path.name):
        if candidate.is_file():
            return candidate
    if path.absolute().parent.is_dir():
        return path
    raise ResumeError(f"the run's task file {recorded!r} isn't here; name it too: grip run FILE --resume ...")


def _ask(question: Question) -> bool:
    sys.stderr.write(f"{question}. Go on? [y/N] ")
    sys.stderr.flush()
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _say(text: str) -> None:
    print(f"  {text}", file=sys.stderr, flush=True)
