"""`grip demo`: a packaged demonstration from end to end, with the referee's word at the end."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from grip_bt.app.runs.demo import ATTEMPT, DEMOS, Attempt, AttemptRecorder, Demo, attempt_line, demo_task, object_table
from grip_bt.app.runs.execute import Session, open_session
from grip_bt.app.runs.verdict import Verdict
from grip_bt.compilers.binding import parts_of
from grip_bt.runtime import RunResult
from grip_bt.runtime.control import RunEnd, result_facts
from grip_bt.task import walk

from .run import add_run_options, exit_status, options_of, sentence
from .terminal import on_hang_up, on_stop


def add_demo(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    first, *_ = DEMOS
    parser.add_argument("name", nargs="?", default=first, choices=tuple(DEMOS), help=f"which one (default: {first})")
    add_run_options(parser)
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    parser.add_argument("--gui", action="store_true", help="show the run live in a browser")
    parser.add_argument("--port", type=int, default=0, help="of the page (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the page's address")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Run the demonstration; 0 only when the referee agrees that everything was done."""
    demo, task = DEMOS[args.name], demo_task(args.name)
    if args.gui:
        return _show(task, args)
    began = time.monotonic()
    say: Callable[[str], None] = (lambda text: None) if args.json else print
    form = "state machine" if args.target == "sm" else "behaviour tree"
    say(f"GRIP demo {args.name!r} as a {form}, seed {args.seed}\n{demo.doc}\n")
    with open_session(task, options_of(args), progress=lambda p, d: say(f"  {p:<11} {d}")) as session:
        nodes = sum(1 for _ in walk(session.document.task.root))
        say(f"  {'task':<11} {task.name}: {nodes} nodes, no problems\n")
        on_stop(session.runner.stop)
        recorder = _recorder(demo, session, say)
        session.runner.observe(recorder)
        verdict = Verdict(session)
        result = session.runner.run()
        end: RunEnd = {**result_facts(result), **verdict.facts(result)}
        truth = session.resources.referee.truth() if session.resources.referee is not None else {}
        run_id, journal = session.runner.run_id, session.journal
    wall = time.monotonic() - began
    placed = sum(state.status == "placed" for state in truth.values())
    if args.json:
        print(json.dumps(_summary(result, recorder.attempts, placed, len(truth), wall)))
    else:
        print("", *object_table(truth, recorder.attempts), "", sep="\n")
        print(f"{sentence(end)}. The referee: {placed} of {len(truth)} objects lie in the crate.")
        print(f"{result.duration:.1f} s on the run's clock, {wall:.1f} s in all; run {run_id} in {journal}")
    return exit_status(end)


def _recorder(demo: Demo, session: Session, say: Callable[[str], None]) -> AttemptRecorder:
    referee = session.resources.referee
    clock = session.runner.context.clock
    return AttemptRecorder(
        ATTEMPT,
        f"{ATTEMPT}/{demo.check}",
        clock.now,
        referee.truth if referee is not None else None,
        lambda attempt: say(attempt_line(attempt)),
        parts_of(session.runner.compiled)[ATTEMPT].meaning,
    )


def _summary(result: RunResult, attempts: list[Attempt], placed: int, objects: int, wall: float) -> dict[str, Any]:
    return {
        "status": result.status,
        "outcome": result.outcome,
        "placed": placed,
        "objects": objects,
        "attempts": sum(a.outcome != "nothing_left" for a in attempts),
        "failures": [f"{a.where}: {a.failure.code}" for a in attempts if a.failure is not None],
        "false_placements": sum("place" in dict(a.steps) and not a.held for a in attempts),
        "checks": [{"said": a.said, "held": bool(a.held)} for a in attempts if a.said],
        "simulated": result.duration,
        "wall_in_all": wall,
        "message": str(result.error or result.failure or ""),
    }


def _show(task: Path, args: argparse.Namespace) -> int:
    from grip_gui import RunOptions, serve

    on_hang_up(lambda: signal.raise_signal(signal.SIGINT))  # the server obeys that
    options = RunOptions(target=args.target, robot=args.robot, seed=args.seed, pace=args.pace or 1.0)
    return serve(
        task.parent.parent,
        task=task,
        autostart=options,
        port=args.port,
        open_browser=not args.no_browser and sys.stdout.isatty(),
    )
