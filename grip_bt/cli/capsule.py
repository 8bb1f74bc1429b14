"""`grip capsule`: a run as one HTML file that opens anywhere."""

from __future__ import annotations

import argparse
from pathlib import Path

from grip_bt.app.runs.capsule import write_capsule
from grip_bt.app.runs.replay import find_run, journal_of
from grip_bt.runtime import JournalReader


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("run_name", metavar="RUN", help="a run's id, its beginning, or `last`")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="where to (default: RUN.html)")
    parser.add_argument("--journal", type=Path, metavar="FILE", help="another journal than that of this project")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Write the file, and say how large it is."""
    with JournalReader(journal_of(None, args.journal)) as reader:
        found = find_run(reader, args.run_name)
        file = args.output or Path(f"{found}.html")
        made = write_capsule(reader, found, file)
        print(f"{file}: {made.events} events of run {found}, {made.size / 1000:.0f} kB")
        if made.left_out:
            print(f"  left out: {made.left_out}")
        reader.raise_if_damaged()
    return 0
