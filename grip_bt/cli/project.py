"""`grip new` makes a project, `grip fmt` brings its tasks into canonical form, `grip edit` shows them in a browser."""

from __future__ import annotations

import argparse
import shlex
import signal
import sys
from pathlib import Path

from grip_bt.app.project.folder import make_project
from grip_bt.base.errors import DocumentError
from grip_bt.base.files import replace_text
from grip_bt.base.yaml.tree import read_file
from grip_bt.cli.parser import add_no_code
from grip_bt.cli.terminal import on_hang_up, put
from grip_bt.task import fmt


def add_new(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("folder", metavar="DIR", help="a new or empty folder")
    parser.set_defaults(run=_run_new)


def _run_new(args: argparse.Namespace) -> int:
    written = make_project(args.folder)
    print(f"{args.folder}: {', '.join(str(file) for file in written)}")
    folder = shlex.quote(args.folder)
    print(f"next: grip run {folder}/tasks/first.yaml --robot fake, or `grip edit {folder}`")
    return 0


def add_fmt(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("tasks", nargs="+", metavar="TASK", help="a task file; - reads stdin and writes stdout")
    parser.add_argument("--check", action="store_true", help="change nothing; 1 when a file isn't canonical")
    parser.set_defaults(run=_run_fmt)


def _run_fmt(args: argparse.Namespace) -> int:
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


def add_edit(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument(
        "path", nargs="?", default=".", type=Path, help="a project folder or a task file (default: here)"
    )
    parser.add_argument("--port", type=int, default=0, help="port on this machine (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    add_no_code(parser)
    parser.set_defaults(run=_run_edit)


def _run_edit(args: argparse.Namespace) -> int:
    from grip_gui import serve  # here, since `grip edit --help` needs no extra

    if not args.path.exists():
        raise DocumentError("does not exist; give a project folder or a task file", str(args.path))
    on_hang_up(lambda: signal.raise_signal(signal.SIGINT))  # the server obeys that
    task = args.path if args.path.is_file() and args.path.name != "grip.yaml" else None
    return serve(args.path, task=task, port=args.port, open_browser=not args.no_browser)
