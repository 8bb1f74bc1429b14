"""`grip fmt`: task files in canonical form, comments kept."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from grip_bt.base.files import replace_text
from grip_bt.base.yaml.tree import read_file
from grip_bt.task import fmt

from .terminal import put


def add_fmt(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("tasks", nargs="+", metavar="TASK", help="a task file; - reads stdin and writes stdout")
    parser.add_argument("--check", action="store_true", help="change nothing; 1 when a file isn't canonical")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Format the files; with --check, 1 when one would change."""
    formatted = {path: _both(path) for path in args.tasks}  # a file that can't be read stops all before any is written
    changed = [path for path, (before, after) in formatted.items() if before != after]
    if args.check:
        for path in changed:
            print(f"{path}: not formatted; run `grip fmt {path}`")
        return int(bool(changed))
    for path in formatted:
        if path == "-":
            put(formatted[path][1])
        elif path in changed:
            replace_text(Path(path), formatted[path][1])
            print(f"{path}: formatted")
    return 0


def _both(path: str) -> tuple[str, str]:
    before = sys.stdin.read() if path == "-" else read_file(path)
    return before, fmt(before, "<stdin>" if path == "-" else path)
