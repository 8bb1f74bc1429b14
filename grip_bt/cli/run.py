"""`grip run`: run a task of a project, in a process of its own that is watched over."""

from __future__ import annotations

import argparse
import json
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from grip_bt.app.runs.execute import MOST_SEED, RunOptions, open_session
from grip_bt.app.runs.injection import read_faults
from grip_bt.app.runs.mocks import read_mocks
from grip_bt.app.runs.supervisor import Supervisor
from grip_bt.app.runs.tables import failures
from grip_bt.app.runs.verdict import Verdict, words
from grip_bt.app.wiring.parts import silent
from grip_bt.runtime import JournalReader, RunResult, serve_control
from grip_bt.runtime.control import RunEnd, result_facts

from . import DONE, FAILURE, INVALID, NODE_ERROR, STOPPED
from .debug_prompt import Prompt, breakpoint_of
from .parser import add_no_code, number, whole
from .resume import Given, add_resume_options, check_usage, fork_often, prepare
from .terminal import on_stop, progress

_EXIT_STATUS = {"success": DONE, "failure": FAILURE, "error": NODE_ERROR, "died": NODE_ERROR, "stopped": STOPPED}
_WATCHDOG = 10.0


def add_run(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument(
        "task",
        type=Path,
        nargs="?",
        help="the task file; or code that makes a tree of py_trees, which is run as it is: module:function,"
        " file.py:function(argument=3), or file.py, a program; with --resume or --fork, the task's current location",
    )
    add_run_options(parser)
    parser.add_argument("--set", dest="data", action="append", default=[], metavar="VAR=VALUE", type=_assignment)
    parser.add_argument("--journal", type=Path, metavar="FILE", help="where to write (default: the project's own)")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    parser.add_argument(
        "--rate", type=number(above=0), action=Given, metavar="HZ", help="tick rate [Hz] (default: tick on events)"
    )
    parser.add_argument(
        "--ticks",
        type=whole(1, 10**9),
        metavar="N",
        help="tick a tree of py_trees N times, whether its root ends or not (default: until it ends)",
    )
    parser.add_argument(
        "--watchdog",
        type=number(what="a number of seconds"),
        action=Given,
        default=_WATCHDOG,
        metavar="S",
        help=f"end a run whose node doesn't return for S seconds (default: {_WATCHDOG:g}; 0: never)",
    )
    parser.add_argument(
        "--stand-ins",
        action="store_true",
        help="dry run of an imported SMACH task: missing packages, services, actions, topics and parameters are stood"
        " in for, and named; waiting takes no time",
    )
    mocked = parser.add_argument_group("mocks")
    mocked.add_argument(
        "--mock", action="append", default=[], metavar="NODE=SCRIPT", help="script such as failure.no_ik,success"
    )
    mocked.add_argument("--mocks", type=Path, metavar="FILE", help="scripts of several nodes (YAML)")
    way = parser.add_argument_group("control").add_mutually_exclusive_group()
    way.add_argument("--control", action="store_true", help="JSON commands on stdin, JSON events on stdout")
    way.add_argument(
        "--debug", action="store_true", help="interactive debugger: start paused, step, set breakpoints, inspect data"
    )
    parser.add_argument(
        "--break",
        dest="breaks",
        action="append",
        default=[],
        type=breakpoint_of,
        metavar="PLACE",
        help="pause there: 'NODE', 'NODE:OUTCOME', 'NODE if EXPRESSION' (implies --debug, unless --control)",
    )
    parser.add_argument(
        "--in-process", action="store_true", help="run in this process, for debuggers and profilers of Python"
    )
    add_no_code(parser)
    add_resume_options(parser)
    parser.set_defaults(run=run)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add what `run` and `demo` have in common."""
    parser.add_argument("--as", dest="target", choices=("bt", "sm"), default="bt", help="behaviour tree, state machine")
    parser.add_argument(
        "--robot",
        choices=("sim", "fake", "ros"),
        default="sim",
        action=Given,
        help="simulated, fakes that succeed at once, or the controllers of a real robot",
    )
    parser.add_argument(
        "--seed",
        type=whole(0, MOST_SEED),
        default=0,
        action=Given,
        metavar="N",
        help="of the simulated world (default: 0)",
    )
    parser.add_argument(
        "--pace",
        type=number(above=0, advice="; leave it out for as fast as the simulation goes"),
        action=Given,
        metavar="X",
        help="playback speed: simulated seconds a second (default: as fast as it goes)",
    )
    parser.add_argument(
        "--fault",
        dest="faults",
        action="append",
        default=[],
        metavar="NAME: {fault: KIND, ...}",
        help="what goes wrong in the simulated world, as in its file: 'slip: {fault: drop, node: lift, chance: 0.3}'",
    )
    shown = parser.add_argument_group("what the simulated world looks like")
    shown.add_argument(
        "--video", type=Path, metavar="FILE.mp4", help="film it, 25 frames a second of simulated time; changes no run"
    )
    shown.add_argument("--picture", type=Path, metavar="FILE.png", help="take a picture in the end")
    shown.add_argument(
        "--view",
        default="",
        metavar="CAMERA",
        help="by this camera of the world (default: its first), or X,Y,Z,X,Y,Z: from where to where [m]",
    )


def options_of(args: argparse.Namespace) -> RunOptions:
    """Return the options that a command line gave."""
    return RunOptions(
        target=args.target,
        robot=args.robot,
        seed=args.seed,
        pace=args.pace,
        faults=read_faults(args.faults),
        video=args.video and args.video.absolute(),
        picture=args.picture and args.picture.absolute(),
        view=args.view,
    )


def run(args: argparse.Namespace) -> int:
    """Run the task; the exit status tells how it ended."""
    check_usage(args, args.usage_error)
    debug = args.debug or (bool(args.breaks) and not args.control)
    options = replace(
        options_of(args),
        data=dict(args.data),
        journal=args.journal,
        rate=args.rate,
        ticks=args.ticks,
        watchdog=args.watchdog or None,
        breaks=args.breaks,
        paused=debug and not args.breaks,
        mocks=read_mocks(args.mocks, args.mock),
        durable=args.durable,
        stand_ins=args.stand_ins,
    )
    if args.resume or args.fork:
        given = getattr(args, "given", frozenset()) | ({"mocks"} if options.mocks else frozenset())
        ready = prepare(args, options, given)
        args.task, options = ready.task, ready.options
        if args.times > 1:
            return fork_often(ready, args.times, args.json, lambda each: _supervise(args, each, debug))
    if args.in_process:
        return _run_here(args, options)
    return _supervise(args, options, debug)[0]


def _run_here(args: argparse.Namespace, options: RunOptions) -> int:
    end: RunEnd = {}
    with open_session(args.task, options, progress=silent if args.json and not args.control else progress) as session:
        on_stop(session.runner.stop)
        verdict = Verdict(session)

        def more(result: RunResult) -> RunEnd:
            end.update({**result_facts(result), **verdict.facts(result)})
            return end

        if args.control:
            serve_control(session.runner, sys.stdin, sys.stdout, more)
        else:
            more(session.runner.run())
            _tell({**end, "run": session.runner.run_id}, args.json)
    return exit_status(end)


def exit_status(end: RunEnd) -> int:
    """Return the exit status of a run, from the facts of the event `ended`; a success that is contradicted is none."""
    return _EXIT_STATUS["failure" if end.get("contradiction") else end["status"]]


def _supervise(args: argparse.Namespace, options: RunOptions, debug: bool) -> tuple[int, RunEnd]:
    """Run in a child process; pass on what goes either way. Return the exit status, and the event `ended`."""
    started: list[Mapping[str, Any]] = []
    prompt: Prompt | None = None

    def told(event: Mapping[str, Any]) -> None:
        if event["event"] == "started":
            started.append(event)
        if event["event"] == "progress":
            if args.control or not args.json:
                progress(event["part"], event["detail"])
        elif args.control and event["event"] != "failed":
            try:
                print(json.dumps(event), flush=True)
            except (OSError, ValueError):
                supervisor.stop(lost=True)
        elif prompt is not None:
            prompt.told(event)

    supervisor = Supervisor(str(args.task), options, told, options.watchdog, own_input=not (args.control or debug))
    if debug:
        prompt = Prompt(supervisor.send, lambda text: print(text, flush=True), patient=not sys.stdin.isatty())
    supervisor.start()
    on_stop(supervisor.stop)
    if args.control:
        _in_background(lambda: _pass_on(supervisor))
    elif prompt is not None:
        _in_background(partial(prompt.listen, sys.stdin))
    end = supervisor.wait()
    if end["event"] == "failed":
        print(end["message"], file=sys.stderr)
        return INVALID, end
    if not args.control:
        _tell({**end, "run": started[0]["run"] if started else None}, args.json)
        if started and not args.json:
            _tell_failures(started[0], end["message"])
    return exit_status(end), end


def _tell_failures(started: Mapping[str, Any], said: str) -> None:
    """Print why leaves failed, also where the task has recovered from it; not what was said already."""
    with JournalReader(started["journal"]) as reader:
        found = failures(reader.events(started["run"]))
    if sum(count for count, _ in found.values()) > 1 or not said:
        for (path, code), (count, message) in found.items():
            print(f"  {count:>3}x {path}: {code}" + (f": {message}" if message else ""))


def _pass_on(supervisor: Supervisor) -> None:
    """Pass commands on, line by line; at the end of input whoever gave them has gone."""
    try:
        for line in open(0, closefd=False):  # not sys.stdin, whose lock would be held at our exit
            try:
                command = json.loads(line)
            except ValueError:
                command = {"command": line.strip()}  # the run refuses it, with the words for that
            supervisor.send(command if isinstance(command, dict) else {"command": command})
    except (OSError, ValueError):
        pass  # closed under our feet, which is an end too
    supervisor.stop(lost=True)


def _in_background(action: Callable[[], None]) -> None:
    threading.Thread(target=action, name="grip_input", daemon=True).start()


def sentence(end: RunEnd) -> str:
    """Return how a run ended, in a line, from the facts of the event `ended`."""
    left = f"; left behind: {', '.join(end['zombies'])}" if end.get("zombies") else ""
    if end["outcome"] is None:
        rest = f"; {end['rest']}" if end.get("rest") else ""
        return f"{end['status']}" + (f": {end['message']}" if end["message"] else "") + rest + left
    reason = f" ({end['message']})" if end["message"] else ""
    return f"{end['status']}: {end['outcome']}{reason}{left}"


def _tell(end: RunEnd, as_json: bool) -> None:
    if as_json:
        keys = ("run", "status", "outcome", "code", "message", "duration", "ticks", "zombies", "rest", "unconfirmed")
        said = {key: end[key] for key in ("truth", "judged", "contradiction") if key in end}
        print(json.dumps({**{key: end.get(key) for key in keys}, **said}))
    else:
        took = f"{end['duration']:.1f} s, " if end.get("duration") is not None else ""
        ticks = f"{end['ticks']} ticks, " if end.get("ticks") is not None else ""
        named = f"run {end['run']}" if end.get("run") else "no run was started"
        print(f"{sentence(end)}; {took}{ticks}{named}")
        if "truth" in end:
            print(f"the referee: {words(end['truth'])}")
        for name, true in end.get("judged", {}).items():
            print(f"{name}: {'yes' if true else 'no'}")


def _assignment(text: str) -> tuple[str, Any]:
    name, found, value = text.partition("=")
    if not found or not name:
        raise argparse.ArgumentTypeError(f"{text!r} isn't VAR=VALUE")
    try:
        return name, json.loads(value)
    except ValueError:
        return name, value
