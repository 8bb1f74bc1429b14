"""`grip demo`: a task of the example project from end to end."""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grip_bt.app.project.examples import examples_folder
from grip_bt.app.runs.execute import open_session
from grip_bt.app.runs.verdict import Verdict
from grip_bt.app.wiring.parts import silent
from grip_bt.base.values import Failure
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.cli.bench import add_bench, run_bench
from grip_bt.cli.run import add_run_options, exit_status, options_of, tell_end, tell_failures
from grip_bt.cli.signals import on_hang_up, on_stop
from grip_bt.cli.terminal import progress
from grip_bt.nodes.node import Observer
from grip_bt.runtime.control import RunEnd, result_facts

ATTEMPT = "next_object/attempt"
"""Path of the node that is one attempt, where things are taken one after the other."""


@dataclass(frozen=True)
class Demo:
    """A demonstration.

    Attributes:
        task: its file's name without `.yaml`.
        doc: a sentence for people.
        attempt: path of the node that is one attempt.
        project: its folder among the examples.
        campaign: the campaign there that is run in place of one task.
    """

    task: str
    doc: str
    attempt: str = ATTEMPT
    project: str = ""
    campaign: str = ""


DEMOS = {
    name: Demo(**said) for name, said in to_data(parse(Path(__file__).with_name("demos.yaml").read_text())).items()
}


def add_demo(parser: argparse.ArgumentParser) -> None:
    first, *_ = DEMOS
    parser.add_argument("name", nargs="?", default=first, choices=tuple(DEMOS), help=f"which one (default: {first})")
    add_run_options(parser)
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
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
    said = silent if args.json else progress
    if not args.json:
        form = "state machine" if args.target == "sm" else "behaviour tree"
        print(f"GRIP demo {args.name!r} as a {form}, seed {args.seed}\n{demo.doc}", flush=True)
    with open_session(task, options_of(args), progress=said) as session:
        runner = session.runner
        on_stop(runner.stop)
        runner.observe(_Attempts(demo.attempt, runner.context.clock.now, said))
        verdict = Verdict(session)
        result = runner.run()
        end: RunEnd = {**result_facts(result), **verdict.facts(result)}
    tell_end({**end, "run": runner.run_id}, args.json)
    if runner.run_id is not None and not args.json:
        tell_failures(session.journal, runner.run_id, end["message"])
    return exit_status(end)


class _Attempts(Observer):
    """Says how each turn of the task's attempt ends."""

    def __init__(self, path: str, now: Callable[[], float], say: Callable[[str, str], None]):
        self._path, self._now, self._say = path, now, say
        self._number, self._began = 0, 0.0

    def entered(self, path: str) -> None:
        if path == self._path:
            self._number, self._began = self._number + 1, self._now()

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        if path == self._path:
            why = f": {failure}" if failure is not None else ""
            self._say(f"attempt {self._number}", f"{self._now() - self._began:5.1f} s  {outcome}{why}")


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
