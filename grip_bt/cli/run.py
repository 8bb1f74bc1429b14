"""`grip run`: run a task of a project."""

from __future__ import annotations

import argparse
import json
import signal
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the verbs are listed without loading what they run
    from grip_bt.app import RunOptions
    from grip_bt.runtime import Runner, RunResult

EXIT_STATUS = {"success": 0, "failure": 3, "error": 4, "stopped": 130}


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("run", help="run a task")
    parser.add_argument("task", type=Path, help="the task file")
    add_run_options(parser)
    parser.add_argument("--set", dest="data", action="append", default=[], metavar="VAR=VALUE", type=_assignment)
    parser.add_argument("--journal", type=Path, metavar="FILE", help="where to write (default: the project's own)")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    parser.add_argument("--control", action="store_true", help="JSON commands on stdin, JSON events on stdout")
    parser.set_defaults(run=run)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add what `run` and `demo` have in common."""
    parser.add_argument("--as", dest="target", choices=("bt", "sm"), default="bt", help="behaviour tree, state machine")
    parser.add_argument("--robot", choices=("sim", "fake"), default="sim", help="simulated, or parts that do as asked")
    parser.add_argument("--seed", type=int, default=0, help="of the simulated world (default: 0)")
    parser.add_argument(
        "--pace", type=float, metavar="X", help="simulated seconds a second (default: as fast as it goes)"
    )


def options_of(args: argparse.Namespace) -> RunOptions:
    """Return the options that a command line gave."""
    from grip_bt.app import RunOptions

    return RunOptions(target=args.target, robot=args.robot, seed=args.seed, pace=args.pace)


def run(args: argparse.Namespace) -> int:
    """Run the task; the exit status tells how it ended."""
    from grip_bt.app import open_session
    from grip_bt.runtime import serve_control

    options = replace(options_of(args), data=dict(args.data), journal=args.journal)
    with open_session(args.task, options, progress=_tell_progress if args.control else _progress) as session:
        stop_on_signals(session.runner)
        if args.control:
            result = serve_control(session.runner, sys.stdin, sys.stdout)
        else:
            result = session.runner.run()
            _tell(result, session.runner, args.json)
    return EXIT_STATUS[result.status]


def stop_on_signals(runner: Runner) -> None:
    """Have SIGINT and SIGTERM stop the run: everything is halted and closed, then we exit."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: runner.stop())


def describe(result: RunResult) -> str:
    """Return how a run ended, in a line."""
    if result.error is not None:
        return f"error: {result.error}"
    if result.outcome is None:
        return result.status
    reason = f" ({result.failure})" if result.failure is not None else ""
    return f"{result.status}: {result.outcome}{reason}"


def _tell(result: RunResult, runner: Runner, as_json: bool) -> None:
    if as_json:
        facts = {
            "run": runner.run_id,
            "status": result.status,
            "outcome": result.outcome,
            "code": result.failure.code if result.failure else None,
            "message": str(result.error or result.failure or ""),
            "duration": result.duration,
            "ticks": result.ticks,
        }
        print(json.dumps(facts))
    else:
        print(f"{describe(result)}; {result.duration:.1f} s, {result.ticks} ticks, run {runner.run_id}")


def _progress(part: str, detail: str) -> None:
    if sys.stderr.isatty():
        _tell_progress(part, detail)


def _tell_progress(part: str, detail: str) -> None:
    print(f"  {part:<11} {detail}", file=sys.stderr, flush=True)


def _assignment(text: str) -> tuple[str, Any]:
    name, found, value = text.partition("=")
    if not found or not name:
        raise argparse.ArgumentTypeError(f"{text!r} isn't VAR=VALUE")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value
