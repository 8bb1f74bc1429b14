"""`grip new`: a project folder with a first task that runs."""

from __future__ import annotations

import argparse
import shlex

from grip_bt.app.project.folder import make_project


def add_new(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("folder", metavar="DIR", help="a new or empty folder")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Make the project and say how to go on."""
    written = make_project(args.folder)
    print(f"{args.folder}: {', '.join(str(file) for file in written)}")
    folder = shlex.quote(args.folder)
    print(f"next: grip run {folder}/tasks/first.yaml --robot fake, or `grip edit {folder}`")
    return 0
