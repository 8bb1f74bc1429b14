"""`grip edit`: the editor, in a browser."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .parser import add_no_code
from .terminal import on_hang_up


def add_edit(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument(
        "path", nargs="?", default=".", type=Path, help="a project folder or a task file (default: here)"
    )
    parser.add_argument("--port", type=int, default=0, help="port on this machine (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    add_no_code(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl-C."""
    from grip_gui import serve  # here, since `grip edit --help` needs no extra

    if not args.path.exists():
        raise DocumentError("does not exist; give a project folder or a task file", str(args.path))
    on_hang_up(lambda: signal.raise_signal(signal.SIGINT))  # the server obeys that
    task = args.path if args.path.is_file() and args.path.name != "grip.yaml" else None
    return serve(args.path, task=task, port=args.port, open_browser=not args.no_browser)
