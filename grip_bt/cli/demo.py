"""`grip demo`: a task of the example project from end to end, and its attempts as the referee sees them."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.app.project.examples import examples_folder
from grip_bt.app.runs.execute import open_session
from grip_bt.app.runs.verdict import Verdict, words
from grip_bt.base.values import Failure, Grasp
from grip_bt.cli.bench import add_bench, run_bench
from grip_bt.cli.run import add_run_options, exit_status, options_of, sentence, tell_end
from grip_bt.cli.terminal import on_hang_up, on_stop
from grip_bt.compilers.binding import parts_of
from grip_bt.nodes.node import Observer
from grip_bt.runtime import RunResult
from grip_bt.runtime.control import RunEnd, result_facts
from grip_bt.task import walk
from grip_sim.referee import ObjectTruth

ATTEMPT = "next_object/attempt"
"""Path of the node that is one attempt, where things are taken one after the other."""


@dataclass(frozen=True)
class Demo:
    """A demonstration.

    Attributes:
        task: its file's name without `.yaml`.
        doc: a sentence for people.
        check: path of the leaf that checks whether something is held; empty where there are no attempts.
        attempt: path of the node that is one attempt.
        project: its folder among the examples.
        campaign: the campaign there that is run in place of one task.
    """

    task: str
    doc: str
    check: str = ""
    attempt: str = ATTEMPT
    project: str = ""
    campaign: str = ""


DEMOS = {
    "clear_table": Demo(
        "reactive_pick",
        "A Panda arm with an Allegro hand clears a table: look, choose a grasp, take, check by all evidence, place.",
        f"{ATTEMPT}/check/held",
    ),
    "reactive": Demo(
        "reactive",
        "Placing only after a component's image difference says that the object was taken; else another pose is drawn.",
        f"{ATTEMPT}/check/grasped",
    ),
    "explore": Demo(
        "explore",
        "A camera on the wrist looks at a heap from all sides; a component registers the views; one thing is taken.",
        "attempt/check",
        "attempt",
        "explore",
    ),
    "unscrew": Demo(
        "unscrew",
        "One arm holds a bottle; the other one's Allegro hand unscrews its cap with its fingertips.",
        project="unscrew",
    ),
    "benchmark": Demo(
        "benchmark",
        "Four methods to grasp, each in a component with conventions of its own, on things that fell onto a table.",
        project="benchmark",
        campaign="campaigns/demo.yaml",
    ),
}


def add_demo(parser: argparse.ArgumentParser) -> None:
    first, *_ = DEMOS
    parser.add_argument("name", nargs="?", default=first, choices=tuple(DEMOS), help=f"which one (default: {first})")
    add_run_options(parser)
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    parser.add_argument("--gui", action="store_true", help="show the run live in a browser")
    parser.add_argument("--port", type=int, default=0, help="of the page (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the page's address")


def run_demo(args: argparse.Namespace) -> int:
    """Run the demonstration; 0 only when the referee agrees that everything was done."""
    demo, task = DEMOS[args.name], demo_task(args.name)
    if args.gui:
        return _show(task, args)
    if demo.campaign:
        return _measure(task.parent.parent / demo.campaign, args.json)
    began = time.monotonic()
    say: Callable[[str], None] = (lambda text: None) if args.json else print
    form = "state machine" if args.target == "sm" else "behaviour tree"
    say(f"GRIP demo {args.name!r} as a {form}, seed {args.seed}\n{demo.doc}\n")
    with open_session(task, options_of(args), progress=lambda p, d: say(f"  {p:<11} {d}")) as session:
        nodes = sum(1 for _ in walk(session.document.task.root))
        say(f"  {'task':<11} {task.name}: {nodes} nodes, no problems\n")
        on_stop(session.runner.stop)
        referee = session.resources.referee
        recorder = AttemptRecorder(
            demo.attempt,
            demo.check,
            session.runner.context.clock.now,
            referee.truth if referee is not None else None,
            lambda attempt: say(attempt_line(attempt)),
            parts_of(session.runner.compiled)[demo.attempt].meaning if demo.check else {},
        )
        session.runner.observe(recorder)
        verdict = Verdict(session)
        result = session.runner.run()
        end: RunEnd = {**result_facts(result), **verdict.facts(result)}
        run_id, journal = session.runner.run_id, session.journal
    wall, truth = time.monotonic() - began, end.get("truth", {})
    placed = sum(state == "placed" for state in truth.values())
    if not demo.check:
        tell_end({**end, "run": run_id}, args.json)
    elif args.json:
        print(json.dumps(summary(result, recorder.attempts, placed, len(truth), wall)))
    else:
        print(f"\n{sentence(end)}. The referee: {words(truth)}.")
        print(f"{result.duration:.1f} s on the run's clock, {wall:.1f} s in all; run {run_id} in {journal}")
    return exit_status(end)


def summary(result: RunResult, attempts: list[Attempt], placed: int, objects: int, wall: float) -> dict[str, Any]:
    """Return what a demonstration comes to; `wall` is in s."""
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


def _measure(campaign: Path, as_json: bool) -> int:
    parser = argparse.ArgumentParser()
    add_bench(parser)
    results = Path(tempfile.mkdtemp(prefix="grip_demo_")) / f"{campaign.stem}.jsonl"
    return run_bench(parser.parse_args([str(campaign), "-o", str(results), *(["--json"] if as_json else [])]))


def _show(task: Path, args: argparse.Namespace) -> int:
    from grip_gui.server import serve
    from grip_gui.wire.runs import RunOptions

    on_hang_up(lambda: signal.raise_signal(signal.SIGINT))  # the server obeys that
    options = RunOptions(target=args.target, robot=args.robot, seed=args.seed, pace=args.pace or 1.0)
    browser = not args.no_browser and sys.stdout.isatty()
    return serve(task.parent.parent, task=task, autostart=options, port=args.port, open_browser=browser)


def demo_task(name: str = "clear_table") -> Path:
    """Return a demonstration's task file."""
    return examples_folder() / DEMOS[name].project / "tasks" / f"{DEMOS[name].task}.yaml"


_Truth = Callable[[], Mapping[str, ObjectTruth]]
"""Asks the referee."""


@dataclass
class Attempt:
    """One turn of the task's attempt node.

    Attributes:
        target: the object nearest to the chosen grasp, None while none was chosen.
        steps: leaf -> outcome (and failure code), in order of their ends.
        outcome: how the attempt node ended; None when it was interrupted.
        where: path of the leaf that failed first.
        held: objects that the referee saw in the hand when the task checked.
        said: how the leaf ended that checks it; empty where it wasn't reached.
    """

    number: int
    target: str | None = None
    steps: list[tuple[str, str]] = field(default_factory=list)
    outcome: str | None = None
    failure: Failure | None = None
    where: str = ""
    held: tuple[str, ...] = ()
    said: str = ""
    duration: float = 0.0


@dataclass
class AttemptRecorder(Observer):
    """An observer that gathers attempts; before the leaf `check`, the referee is asked what is held."""

    attempt: str
    check: str
    clock: Callable[[], float]
    truth: _Truth | None = None
    on_end: Callable[[Attempt], None] = lambda attempt: None
    meaning: Mapping[str, str] = field(default_factory=lambda: {"failure": "failure"})
    attempts: list[Attempt] = field(default_factory=list)
    _began: float = 0.0
    _first: Failure | None = None

    def entered(self, path: str) -> None:
        """Begin an attempt, or ask what is held before the task checks it."""
        if path == self.attempt:
            self._began, self._first = self.clock(), None
            self.attempts.append(Attempt(len(self.attempts) + 1))
        elif path == self.check and self.attempts:
            truth = {} if self.truth is None else self.truth()
            self.attempts[-1].held = tuple(sorted(name for name, seen in truth.items() if seen.status == "held"))

    def wrote(self, path: str, variable: str, type_name: str, value: object) -> None:
        """Take note of which object a chosen grasp is for."""
        if isinstance(value, Grasp) and self.truth is not None and self.attempts:
            truth = self.truth()
            point = value.pose.position + value.pose.rotation()[:, 2] * 0.04
            flat = {n: float(np.linalg.norm(t.pose.position[:2] - point[:2])) for n, t in truth.items()}
            self.attempts[-1].target = min(flat, key=flat.__getitem__, default=None)

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Record a step, or end the attempt."""
        if path == self.attempt:
            self._end(outcome, failure)
        elif path.startswith(self.attempt + "/") and self.attempts:
            if path == self.check:
                self.attempts[-1].said = outcome
            attempt, step = self.attempts[-1], path.removeprefix(self.attempt + "/")
            attempt.steps.append((step, outcome if failure is None else f"{outcome}.{failure.code}"))
            if outcome == "success" and attempt.where.startswith(step + "/"):
                attempt.where, self._first = "", None  # it has been dealt with, as by an `invert`
            if failure is not None and not attempt.where:
                attempt.where, self._first = step, failure

    def interrupted(self, path: str) -> None:
        """End the attempt without an outcome."""
        if path == self.attempt:
            self._end(None, None)

    def _end(self, outcome: str | None, failure: Failure | None) -> None:
        attempt = self.attempts[-1]
        attempt.outcome = outcome
        # A recovery that succeeded leaves a failed attempt without a reason of its own: what it recovered from is it.
        attempt.failure = failure or (self._first if self.meaning.get(outcome or "") == "failure" else None)
        attempt.duration = self.clock() - self._began
        self.on_end(attempt)


def attempt_line(attempt: Attempt) -> str:
    """Return one attempt in a line."""
    what = attempt.target or ("nothing left" if attempt.outcome == "nothing_left" else "no object")
    if attempt.outcome is None:
        how = "stopped"
    elif attempt.failure is not None:
        how = f"failed at {attempt.where or 'the task'}: {attempt.failure}"
    elif attempt.outcome == "success":
        how = "done, and held" if attempt.held else "done, it says; the hand was empty when that was checked"
    elif attempt.said:
        how = f"not placed: the check says {attempt.said}, the hand {'held' if attempt.held else 'held nothing'}"
        how += f" {attempt.target}" if attempt.target in attempt.held else ""
    else:
        how = attempt.outcome.replace("_", " ")
    return f"attempt {attempt.number:<2} {attempt.duration:6.1f} s  {what:<12} {how}"
