"""`grip run`: run a task of a project, in a process of its own that is watched over; or go on with a run."""

from __future__ import annotations

import argparse
import json
import sys
import threading
from collections.abc import Mapping
from contextlib import redirect_stdout, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from grip_bt.app.runs.execute import MOST_SEED, WATCHDOG, RunOptions, open_session
from grip_bt.app.runs.mocks import read_mocks
from grip_bt.app.runs.replay import failures, journal_of
from grip_bt.app.runs.resume_plan import ResumePlan, agree, plan_resume
from grip_bt.app.runs.supervisor import Supervisor
from grip_bt.app.runs.verdict import Verdict, words
from grip_bt.app.wiring.parts import silent
from grip_bt.cli import DONE, FAILURE, INVALID, NODE_ERROR, STOPPED
from grip_bt.cli.parser import STAND_INS, add_no_code, number, whole
from grip_bt.cli.signals import on_stop
from grip_bt.cli.terminal import progress, tell
from grip_bt.runtime import JournalReader, RunResult, serve_control
from grip_bt.runtime.control import RunEnd, result_facts
from grip_sim.faults import read_faults

_EXIT_STATUS = {"success": DONE, "failure": FAILURE, "error": NODE_ERROR, "died": NODE_ERROR, "stopped": STOPPED}


class _Given(argparse.Action):
    """Keeps a value, and that the command line gave it: what it doesn't give is as it was in the run that goes on."""

    def __call__(self, parser: object, namespace: argparse.Namespace, values: object, name: str | None = None) -> None:
        setattr(namespace, self.dest, values)
        namespace.given = getattr(namespace, "given", frozenset()) | {self.dest}


def add_run(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "task",
        type=Path,
        nargs="?",
        help="the task file; or code that makes a tree of py_trees, which is run as it is: module:function,"
        " file.py:function(argument=3), or file.py, a program; with --resume or --fork, the task's current location",
    )
    add_run_options(parser)
    add = parser.add_argument
    add("--set", dest="data", action="append", default=[], metavar="VAR=VALUE", type=_assignment)
    add("--journal", type=Path, metavar="FILE", help="where to write (default: the project's own)")
    add("--json", action="store_true", help="print the result as one JSON object")
    add("--rate", type=number(above=0), action=_Given, metavar="HZ", help="tick rate (default: tick on events)")
    add("--ticks", type=whole(1, 10**9), metavar="N", help="tick a py_trees tree N times (default: until it ends)")
    seconds = number(what="a number of seconds")
    doc = f"end a run whose node hangs for S seconds (default: {WATCHDOG:g}; 0: never)"
    add("--watchdog", type=seconds, action=_Given, default=WATCHDOG, metavar="S", help=doc)
    add("--stand-ins", action="store_true", help=f"SMACH tasks, py_trees trees: {STAND_INS}")
    group = parser.add_argument_group("mocks")
    add = group.add_argument
    script = "what a node does in place of its work, such as failure.no_ik,success"
    add("--mock", action="append", default=[], metavar="NODE=SCRIPT", help=script)
    add("--mocks", type=Path, metavar="FILE", help="scripts of several nodes (YAML)")
    group = parser.add_argument_group("control")
    add = group.add_argument
    add("--control", action="store_true", help="JSON commands on stdin, JSON events on stdout")
    add("--in-process", action="store_true", help="run in this process, for debuggers and profilers of Python")
    add_no_code(parser)
    group = parser.add_argument_group("resuming a run")
    add = group.add_mutually_exclusive_group().add_argument
    add("--resume", metavar="RUN", help="resume a run whose process died; `last` for the last one")
    add("--fork", metavar="RUN", help="a new run that continues from event --at of another one")
    add = group.add_argument
    add("--at", metavar="PLACE", help="with --fork: an event's number, NODE, or NODE:OUTCOME")
    outcome = "force the next outcome of a leaf, such as attempt/grasp=failure.no_ik"
    add("--set-outcome", action="append", default=[], metavar="NODE=OUTCOME", help=outcome)
    add("--yes", action="store_true", help="confirm everything that would be asked")


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add what `run` and `demo` have in common."""
    add = parser.add_argument
    add("--as", dest="target", choices=("bt", "sm"), default="bt", help="behaviour tree, state machine")
    robots = "simulated, fakes that succeed at once, or the controllers of a real robot"
    add("--robot", choices=("sim", "fake", "ros"), default="sim", action=_Given, help=robots)
    seed = "of the simulated world (default: 0)"
    add("--seed", type=whole(0, MOST_SEED), default=0, action=_Given, metavar="N", help=seed)
    pace = number(above=0, advice="; leave it out for as fast as the simulation goes")
    fast = "simulated seconds a second (default: as fast as it goes)"
    add("--pace", type=pace, action=_Given, metavar="X", help=fast)
    add = parser.add_argument_group("the simulated world").add_argument
    other = "in place of the project's; see `grip world list`"
    add("--world", default="", action=_Given, metavar="NAME|FILE", help=other)
    fault = "what goes wrong in it, as in its file: 'slip: {fault: drop, node: lift, chance: 0.3}'"
    add("--fault", dest="faults", action="append", default=[], metavar="NAME: {fault: KIND, ...}", help=fault)
    add("--video", type=Path, metavar="FILE.mp4", help="film it, 25 frames a second of simulated time; changes no run")
    add("--picture", type=Path, metavar="FILE.png", help="take a picture in the end")
    view = "by this camera of the world (default: its first), or X,Y,Z,X,Y,Z: from where to where [m]"
    add("--view", default="", metavar="CAMERA", help=view)


def _check_usage(args: argparse.Namespace) -> None:
    again = args.resume or args.fork
    if args.task is None and not again:
        args.usage_error("a task file is needed, or --resume RUN, or --fork RUN")
    if bool(args.fork) != bool(args.at):
        args.usage_error("--fork RUN and --at PLACE go together")
    if args.set_outcome and not again:
        args.usage_error("--set-outcome goes with --resume or --fork; in a new run, --mock NODE=SCRIPT does that")


def _prepared(args: argparse.Namespace, options: RunOptions) -> ResumePlan:
    """Look at a run that is to go on, and ask what has to be asked."""
    plan = plan_resume(
        journal_of(args.task, args.journal),
        args.resume or args.fork,
        options,
        getattr(args, "given", frozenset()) | ({"mocks"} if options.mocks else frozenset()),
        at=args.at,
        task=args.task,
        outcomes=args.set_outcome,
    )
    asked = args.yes or args.fork  # a fork moves nothing that another run has left behind
    for said in (*plan.notes, *(plan.questions if asked else ())):
        print(f"  {said}", file=sys.stderr, flush=True)
    if not asked:
        agree(plan.questions, _ask if sys.stdin.isatty() else None)
    return plan


def _ask(question: str) -> bool:
    sys.stderr.write(f"{question}. Continue? [y/N] ")
    sys.stderr.flush()
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def options_of(args: argparse.Namespace) -> RunOptions:
    """Return the options that a command line gave."""
    return RunOptions(
        target=args.target,
        robot=args.robot,
        seed=args.seed,
        world=args.world,
        pace=args.pace,
        faults=read_faults(args.faults),
        video=args.video and args.video.absolute(),
        picture=args.picture and args.picture.absolute(),
        view=args.view,
    )


def run_run(args: argparse.Namespace) -> int:
    """Run the task; the exit status tells how it ended."""
    _check_usage(args)
    options = replace(
        options_of(args),
        data=dict(args.data),
        journal=args.journal,
        rate=args.rate,
        ticks=args.ticks,
        watchdog=args.watchdog or None,
        mocks=read_mocks(args.mocks, args.mock),
        stand_ins=args.stand_ins,
    )
    if args.resume or args.fork:
        plan = _prepared(args, options)
        args.task, options = plan.task, plan.options
    return _run_here(args, options) if args.in_process else _supervise(args, options)


def _run_here(args: argparse.Namespace, options: RunOptions) -> int:
    end: RunEnd = {}
    ours, told = sys.stdout, silent if args.json and not args.control else progress
    with (
        redirect_stdout(sys.stderr if args.json or args.control else ours),
        open_session(args.task, options, progress=told) as session,
    ):
        on_stop(session.runner.stop)
        verdict = Verdict(session)

        def more(result: RunResult) -> RunEnd:
            end.update({**result_facts(result), **verdict.facts(result)})
            return end

        if args.control:
            serve_control(session.runner, sys.stdin, ours, more)
        else:
            more(session.runner.run())
    if not args.control:
        tell_end({**end, "run": session.runner.run_id}, args.json)
    return exit_status(end)


def exit_status(end: RunEnd) -> int:
    """Return the exit status of a run, from the facts of the event `ended`; a success that is contradicted is none."""
    return _EXIT_STATUS["failure" if end.get("contradiction") else end["status"]]


def _supervise(args: argparse.Namespace, options: RunOptions) -> int:
    """Run in a child process, pass on what goes either way, and return the exit status."""

    def told(event: Mapping[str, Any]) -> None:
        if event["event"] == "progress":
            if args.control or not args.json:
                progress(event["part"], event["detail"])
        elif args.control and event["event"] != "failed":
            try:
                print(json.dumps(event), flush=True)
            except (OSError, ValueError):
                supervisor.stop(lost=True)

    supervisor = Supervisor(str(args.task), options, told, options.watchdog, terminal=not (args.control or args.json))
    supervisor.start()
    on_stop(supervisor.stop)
    if args.control:
        threading.Thread(target=_pass_on, args=(supervisor,), name="grip_input", daemon=True).start()
    end = supervisor.wait()
    if end["event"] == "failed":
        print(end["message"], file=sys.stderr)
        return INVALID
    if not args.control:
        started = supervisor.started
        tell_end({**end, "run": started["run"] if started else None}, args.json)
        if started and not args.json:
            tell_failures(started["journal"], started["run"], end["message"])
    return exit_status(end)


def tell_failures(journal: Path | str, run: str, said: str) -> None:
    """Print why leaves failed, also where the task has recovered from it; not what was said already."""
    with JournalReader(journal) as reader:
        found = failures(reader.events(run))
    if sum(count for count, _ in found.values()) > 1 or not said:
        for (path, code), (count, message) in found.items():
            print(f"  {count:>3}x {path}: {code}" + (f": {message}" if message else ""))


def _pass_on(supervisor: Supervisor) -> None:
    """Pass commands on, line by line; at the end of input whoever gave them has gone."""
    with suppress(OSError, ValueError):  # closed under our feet, which is an end too
        for line in open(0, closefd=False):  # not sys.stdin, whose lock would be held at our exit
            try:
                command = json.loads(line)
            except ValueError:
                command = {"command": line.strip()}  # the run refuses it, with the words for that
            supervisor.send(command if isinstance(command, dict) else {"command": command})
    supervisor.stop(lost=True)


def sentence(end: RunEnd) -> str:
    """Return how a run ended, in a line, from the facts of the event `ended`."""
    left = f"; left behind: {', '.join(end['zombies'])}" if end.get("zombies") else ""
    if end["outcome"] is not None:
        return f"{end['status']}: {end['outcome']}" + (f" ({end['message']})" if end["message"] else "") + left
    rest = f"; {end['rest']}" if end.get("rest") else ""
    return f"{end['status']}" + (f": {end['message']}" if end["message"] else "") + rest + left


def tell_end(end: RunEnd, as_json: bool) -> None:
    """Print how a run ended, and what the referee says."""
    keys = ("run", "status", "outcome", "code", "message", "duration", "ticks", "zombies", "rest", "unconfirmed")
    said = {key: end[key] for key in ("truth", "judged", "contradiction") if key in end}
    took = f"{end['duration']:.1f} s, " if end.get("duration") is not None else ""
    ticks = f"{n} tick{'s' * (n != 1)}, " if (n := end.get("ticks")) is not None else ""
    named = f"run {end['run']}" if end.get("run") else "no run was started"
    lines = [f"{sentence(end)}; {took}{ticks}{named}"]
    lines += [f"the referee: {words(end['truth'])}"] if "truth" in end else []
    lines += [f"{name}: {'yes' if true else 'no'}" for name, true in end.get("judged", {}).items()]
    facts: dict[str, object] = {key: end.get(key) for key in keys}
    tell(as_json, facts | said, lines)


def _assignment(text: str) -> tuple[str, Any]:
    name, found, value = text.partition("=")
    if not found or not name:
        raise argparse.ArgumentTypeError(f"{text!r} isn't VAR=VALUE")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value
