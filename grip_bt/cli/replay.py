"""`grip replay`: a run of the journal again, in the terminal or on the page."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.replay import Until, events_of, find_run, journal_of, line_of, moment_lines, replay
from grip_bt.base.errors import UnknownNameError
from grip_bt.runtime import Event, JournalReader, RunSnapshot

from .parser import number


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("run_name", metavar="RUN", help="a run's id, its beginning, or `last`")
    parser.add_argument("--journal", type=Path, metavar="FILE", help="another journal than that of this project")
    parser.add_argument(
        "--speed",
        type=number(),
        metavar="X",
        help="seconds of the run in a second (default: 1 in a terminal; else as fast as it goes, which is 0)",
    )
    parser.add_argument("--until", default="", metavar="PLACE", help="end after SEQ, NODE or NODE:OUTCOME")
    parser.add_argument("--step", action="store_true", help="wait for Enter after each event; q ends")
    parser.add_argument("--json", action="store_true", help="an event a line, as JSON")
    parser.add_argument("--gui", action="store_true", help="open the page on this run")
    parser.add_argument("--no-browser", action="store_true", help="with --gui: only print the address")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Show the events."""
    file = journal_of(None, args.journal)
    with JournalReader(file) as reader:
        found = find_run(reader, args.run_name)
        if args.gui:
            return _open_page(file, found, not args.no_browser)
        until = Until(args.until) if args.until else None
        if until is not None and reader.run(found).status != "running":
            _check_place(reader, found, until)
        speed = args.speed if args.speed is not None else float(sys.stdout.isatty())

        def show(event: Event, moment: RunSnapshot) -> None:
            print(json.dumps(asdict(event), ensure_ascii=False) if args.json else line_of(event), flush=bool(speed))
            if args.step and not (until is not None and until.reached(event)):
                _wait_for_enter()

        try:
            moment, reached = replay(events_of(reader, found), show, None if args.step else speed or None, until)
        except EOFError:
            return 0
        if not reached:
            raise _unknown_place(args.until, found, moment.nodes, moment.seq)
        if not args.json:
            print("\n".join(moment_lines(moment, None if until else reader.run(found))))
        reader.raise_if_damaged()
    return 0


def _check_place(reader: JournalReader, run: str, until: Until) -> None:
    """Refuse a place that a run which is over never came to, before its events are shown."""
    paths: set[str] = set()
    ends: set[str] = set()  # of the node, where its name is right
    node, last = until.text.partition(":")[0], 0
    for event in reader.iterate(run):
        if until.reached(event):
            return
        paths.add(event.path)
        if event.path == node and event.outcome is not None:
            ends.add(f"{node}:{event.outcome}")
        last = event.seq
    raise _unknown_place(until.text, run, ends or paths, last)


def _unknown_place(place: str, run: str, paths: Iterable[str], last: int) -> UnknownNameError:
    there = [f"1 to {last}"] if place.isdecimal() else sorted(paths)
    return UnknownNameError("place in the run", place, there, f"run {run}")


def _wait_for_enter() -> None:
    """Wait for a line; `q`, or the end of input, ends the replay."""
    if not (line := sys.stdin.readline()) or line.strip().lower() == "q":
        raise EOFError


def _open_page(journal: Path, run: str, open_browser: bool) -> int:
    from grip_gui import serve  # here, since runs are replayed without the page too

    folder = journal.resolve().parent.parent if journal.parent.name == ".grip" else find_project(Path()).folder
    return serve(folder, show_run=run, journal=journal, open_browser=open_browser)
