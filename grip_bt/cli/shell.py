"""What `grip` does with a command line: finds the verb, runs it, and turns errors into words and an exit status."""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from grip_bt import __version__
from grip_bt.base.errors import GripError, NodeError

from . import streams
from .extras import missing_extra
from .parser import Parser

VERBS = (
    "demo",
    "new",
    "check",
    "fmt",
    "apply",
    "run",
    "convert",
    "import_",
    "component",
    "interfaces",
    "launch",
    "sim",
    "messages",
    "edit",
    "runs",
    "bench",
    "replay",
    "capsule",
    "robot",
    "teach",
    "doctor",
)
INVALID, NODE_ERROR = 1, 4


def make_parser() -> argparse.ArgumentParser:
    """Return the command's parser with all verbs."""
    parser = Parser(
        prog="grip",
        description="Draw, run and measure robot grasping tasks: one graph, behaviour tree or state machine.",
    )
    parser.add_argument("--version", action="version", version=f"grip {__version__}")
    subparsers = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for verb in VERBS:
        import_module(f"grip_bt.cli.{verb}").add_parser(subparsers)
    return parser


def run_verb(arguments: Sequence[str] | None) -> int:
    """Run the verb of a command line and return the exit status; what goes wrong is said on stderr.

    Raises:
        KeyboardInterrupt: Ctrl-C.
        SystemExit: 2, the command line is wrong; 0, help was asked for.
    """
    streams.ready()
    try:
        status = _done(arguments)
        sys.stdout.flush()  # here, where what keeps it from being written can be said
        return status
    except NodeError as error:
        return _said(str(error), NODE_ERROR)
    except GripError as error:
        if getattr(error, "issues", None):
            print(error, file=sys.stderr)
            return INVALID
        return _said(str(error))
    except ModuleNotFoundError as error:
        missing = missing_extra(error)
        if missing is None:
            raise
        return _said(str(missing))
    except BrokenPipeError:
        # The reader went away (`grip ... | head`): nothing more can be said, and nothing is wrong.
        streams.give_up()
        return 0
    except OSError as error:
        return _refused_by_the_system(error)


def _done(arguments: Sequence[str] | None) -> int:
    try:
        args = make_parser().parse_args(arguments)
    except SystemExit:
        sys.stdout.flush()  # the help, which argparse has printed
        raise
    if getattr(args, "no_code", False):
        from grip_bt.app.project.foreign_code import forbid

        forbid()
    return int(args.run(args))


def _refused_by_the_system(error: OSError) -> int:
    """Say which file or folder can't be read or written, and why; any other such error is a bug of ours."""
    if error.filename is None:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise error
        streams.give_up()
        return _said(f"stdout: {error.strerror}; the output isn't whole: send it to another place, or make room")
    name = str(error.filename) if isinstance(error.filename, int) else os.fsdecode(error.filename)
    if error.errno == errno.ENOENT:
        return _said(f"{name}: {error.strerror}; make its folder first, or name another place")
    return _said(f"{name}: {error.strerror}; name another place, or mend its rights")


def _said(words: str, status: int = INVALID) -> int:
    print(f"grip: {words}", file=sys.stderr)
    return status
