"""`grip runs` and `grip replay`: the runs of a project listed, exported, and shown again."""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path

from pydantic import ByteSize, TypeAdapter, ValidationError

from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.execute import make_room
from grip_bt.app.runs.export import export_run
from grip_bt.app.runs.replay import Until, events_of, find_run, journal_of, line_of, moment_lines, replay
from grip_bt.base.errors import UnknownNameError, plural
from grip_bt.cli.parser import number
from grip_bt.cli.terminal import tell
from grip_bt.runtime import Event, JournalReader, RunSnapshot
from grip_bt.runtime.journal_rows import JournalError


def add_runs(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("what", nargs="?", default=".", help="the project or a file in it; or a run's id, or `last`")
    add("--journal", type=Path, metavar="FILE", help="another journal")
    add("--json", action="store_true", help="print JSON")
    add("--to", choices=("jsonl", "csv", "mcap", "rerun", "lerobot"), help="export the run; Foxglove opens mcap")
    where = "where to, with --to; of lerobot the dataset's folder, which grows"
    add("-o", "--output", type=Path, metavar="FILE", help=where)
    add("--data", action="store_true", help="show the last value of each variable that the run wrote")
    doc = "remove the oldest runs that have ended until the journal holds no more, such as 500MB (default: its limit)"
    add("--prune", nargs="?", const="", metavar="SIZE", help=doc)


def run_runs(args: argparse.Namespace) -> int:
    if args.prune is not None:
        return _prune(args)
    if (args.to is None) != (args.output is None):
        args.usage_error("--to and -o go together: grip runs RUN --to mcap -o FILE")
    place = Path(args.what)
    one = args.to is not None or args.data or not place.exists()
    home = find_project(Path() if one and not place.exists() else place).folder
    journal = args.journal or home / ".grip" / "runs.sqlite"
    if not journal.is_file():
        if one and args.journal is None:
            raise UnknownNameError("run", args.what, [], f"{journal}: there are no runs yet")
        return _no_runs(args, journal)
    with JournalReader(journal) as reader:
        run = find_run(reader, "last" if place.exists() else args.what) if one else None
        if run is not None and args.to == "lerobot":
            from grip_bt.app.runs.export_lerobot import add_run  # of the extras `sim` and `parquet`

            print(f"{args.output}: {add_run(reader, run, args.output)} frames of run {run}")
        elif run is not None and args.to is not None:
            print(f"{args.output}: {export_run(reader, run, args.output, args.to)} events of run {run}")
        elif run is not None and args.data:
            _data(reader, run, args.json)
        else:
            _list(reader, args.json, run)
    return 0


def _no_runs(args: argparse.Namespace, file: Path) -> int:
    if args.journal is not None:
        raise JournalError(f"{file}: there is no such journal; name a file that runs were written to")
    tell(args.json, [], [f"no runs yet in {file}"])
    return 0


def _prune(args: argparse.Namespace) -> int:
    project = find_project(Path(args.what))
    try:
        limit = TypeAdapter(ByteSize).validate_python(args.prune) if args.prune else project.file.journal_limit
    except ValidationError:
        args.usage_error(f"--prune {args.prune!r} isn't a size; such as 500MB or 2GiB")
    file = args.journal or project.folder / ".grip" / "runs.sqlite"
    if not file.is_file():
        return _no_runs(args, file)
    pruned = make_room(file, limit, give_back=True)
    held, allowed = (ByteSize(size).human_readable(decimal=True) for size in (pruned.after, limit))
    data = {"removed": pruned.runs, "before": pruned.before, "after": pruned.after}
    tell(args.json, data, [f"{plural(len(pruned.runs), 'run')} removed; {file} holds {held} of {allowed}"])
    return 0


def _data(reader: JournalReader, run: str, as_json: bool) -> None:
    lines = []
    for name, event in (written := reader.variables(run)).items():
        what = f"{event.data.get('type', ''):<16} {event.data.get('preview', '')}"
        lines.append(f"{name:<20} {what}  (by {event.path}, {event.t:.3f} s)")
    tell(as_json, {name: asdict(event) for name, event in written.items()}, lines)


def _list(reader: JournalReader, as_json: bool, only: str | None = None) -> None:
    runs = sorted(reader.runs(), key=lambda record: record.started)
    runs, lines = [record for record in runs if only in (None, record.id)], []
    for record in runs:
        began = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.started))
        took = f"{record.ended - record.started:7.1f} s" if record.ended else "        -"
        ended = f"{record.status:<8} {record.outcome or '-':<12}"
        lines.append(f"{record.id}  {began}  {took}  {record.target}  {ended} {record.task_name}")
    tell(as_json, [asdict(record) for record in runs], lines)


def add_replay(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run_name", metavar="RUN", help="a run's id, its beginning, or `last`")
    parser.add_argument("--journal", type=Path, metavar="FILE", help="use this journal instead of the project's")
    doc = "playback speed (default: 1 on a terminal, otherwise 0: as fast as possible)"
    parser.add_argument("--speed", type=number(), metavar="X", help=doc)
    parser.add_argument("--until", default="", metavar="PLACE", help="end after SEQ, NODE or NODE:OUTCOME")
    parser.add_argument("--step", action="store_true", help="wait for Enter after each event; q ends")
    parser.add_argument("--json", action="store_true", help="print one JSON event per line")
    parser.add_argument("--gui", action="store_true", help="open the page on this run")
    parser.add_argument("--no-browser", action="store_true", help="with --gui: only print its address")


def run_replay(args: argparse.Namespace) -> int:
    file = journal_of(None, args.journal)
    with JournalReader(file) as reader:
        found = find_run(reader, args.run_name)
        if args.gui:
            from grip_gui.server import serve  # here, since runs are replayed without the page too

            folder = file.resolve().parent.parent if file.parent.name == ".grip" else find_project(Path()).folder
            return serve(folder, show_run=found, journal=file, open_browser=not args.no_browser)
        until = Until(args.until) if args.until else None
        if until is not None and reader.run(found).status != "running":
            until.place(list(reader.iterate(found)), found)  # refused before its events are shown
        speed = args.speed if args.speed is not None else float(sys.stdout.isatty())

        def show(event: Event, moment: RunSnapshot) -> None:
            print(json.dumps(asdict(event), ensure_ascii=False) if args.json else line_of(event), flush=bool(speed))
            if args.step and not (until is not None and until.reached(event)):
                if not (line := sys.stdin.readline()) or line.strip().lower() == "q":
                    raise EOFError

        try:
            moment, reached = replay(events_of(reader, found), show, None if args.step else speed or None, until)
        except EOFError:
            return 0
        if until is not None and not reached:
            until.place(list(reader.iterate(found)), found)
        if not args.json:
            print("\n".join(moment_lines(moment, None if until else reader.run(found))))
    return 0
