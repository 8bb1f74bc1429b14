"""`grip runs`: what was run in a project, newest last."""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("runs", help="list the runs of a project")
    parser.add_argument("path", nargs="?", type=Path, default=Path(), help="the project or a file in it")
    parser.add_argument("--journal", type=Path, metavar="FILE", help="another journal")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print a line per run."""
    from grip_bt.app import find_project
    from grip_bt.runtime import JournalReader

    journal = args.journal or find_project(args.path).folder / ".grip" / "runs.sqlite"
    if not journal.is_file():
        print("[]" if args.json else f"no runs yet in {journal}")
        return 0
    with JournalReader(journal) as reader:
        runs = sorted(reader.runs(), key=lambda record: record.started)
    if args.json:
        print(json.dumps([asdict(r) for r in runs]))
        return 0
    for record in runs:
        began = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.started))
        took = f"{record.ended - record.started:7.1f} s" if record.ended else "        -"
        ended = f"{record.status:<8} {record.outcome or '-':<12}"
        print(f"{record.id}  {began}  {took}  {record.target}  {ended} {record.task_name}")
    return 0
