"""`grip`: finds the verb, runs it, and turns GRIP's errors into words and an exit status.

Exit status: 0 done with a success outcome, 1 invalid input, 2 usage, 3 done with a failure outcome, 4 error in a node,
130 stopped.
"""

from __future__ import annotations

import argparse
import errno
import sys
from collections.abc import Sequence
from importlib import import_module

from grip_bt import __version__
from grip_bt.errors import GripError, NodeError

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
INVALID, NODE_ERROR, STOPPED = 1, 4, 130
_OF_THE_PLACE = {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.ENAMETOOLONG}
"""Faults of where somebody wanted something written or read, not ours."""


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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit status."""
    args = make_parser().parse_args(arguments)
    try:
        return int(args.run(args))
    except NodeError as error:
        print(f"grip: {error}", file=sys.stderr)
        return NODE_ERROR
    except GripError as error:
        print(error if getattr(error, "issues", None) else f"grip: {error}", file=sys.stderr)
        return INVALID
    except ModuleNotFoundError as error:
        missing = missing_extra(error)
        if missing is None:
            raise
        print(f"grip: {missing}", file=sys.stderr)
        return INVALID
    except BrokenPipeError:
        # The reader went away (`grip ... | head`): nothing more can be said, and nothing is wrong.
        sys.stderr.close()
        return 0
    except OSError as error:
        if error.errno not in _OF_THE_PLACE or error.filename is None:
            raise
        print(f"grip: {error.filename}: {error.strerror}; name another place, or mend its rights", file=sys.stderr)
        return INVALID
    except KeyboardInterrupt:
        print("grip: stopped", file=sys.stderr)
        return STOPPED


if __name__ == "__main__":
    sys.exit(main())
