"""What `grip` does with a command line: finds the verb, runs it, says what went wrong; how shells complete it."""

from __future__ import annotations

import argparse
import errno
import logging
import os
import sys
import traceback
from collections.abc import Collection, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path

from grip_bt import __version__
from grip_bt.base.errors import GripError, MissingPartError, NodeError, remedy_of
from grip_bt.cli import INVALID, NODE_ERROR, terminal
from grip_bt.cli.parser import Parser
from grip_bt.cli.terminal import complain, give_up, put, ready

VERBS = {
    "demo": "run a packaged demonstration in simulation",
    "new": "make a project folder with a first task that runs",
    "check": "list all issues of tasks, each with its place and a fix",
    "fmt": "bring task files into their canonical form; comments stay",
    "apply": "edit a task by commands; comments and other lines stay",
    "run": "run a task",
    "convert": "convert a task to a picture, or to another form",
    "import": "import tasks: SMACH machines, py_trees and BehaviorTree.CPP trees, the first GRIP",
    "component": "wrap external software: generate its node, list, test",
    "interfaces": "build ROS interface packages",
    "launch": "run and supervise a launch file or a project's processes",
    "sim": "serve the simulator as a ROS 2 robot: joints, controllers, cameras",
    "messages": "manage named joint states, poses, grasps ...: serve, list, show, add, watch, reset",
    "serve": "offer a project's tasks to other ROS 2 software: an action and services",
    "edit": "show a project's tasks in a browser, run them, and replay runs",
    "runs": "list the runs of a project, or export one of them",
    "bench": "run a campaign: tasks on many seeds; compare them",
    "replay": "replay a run event by event, also one in progress",
    "robot": "check a robot's files, show what a robot has, list ready-made ones",
    "object": "list, show and check things that worlds hold, bring in other people's meshes",
    "world": "list, show, picture and check simulated worlds, make one of your own",
    "teach": "remember where an arm or a hand is now, under a name",
    "docs": "open the documentation in a browser, offline",
    "doctor": "check the installation, and say how to fix it, or fix it",
    "completion": "print what makes bash, zsh or fish complete verbs and options",
    "help": "show how a verb is used, or `all` verbs",
}
"""What each does, for the list of them; its module is loaded when the verb is named."""
FIRST = ("demo", "new", "edit", "run", "check", "import", "bench", "doctor")
"""What a newcomer is shown."""
GROUPS = {
    "to begin": ("demo", "new", "docs", "doctor", "completion", "help"),
    "tasks": ("edit", "check", "run", "import", "convert", "fmt", "apply"),
    "what happened, and how often it works": ("runs", "replay", "bench"),
    "robots and worlds": ("robot", "world", "object", "teach"),
    "other software, by ROS 2": ("component", "interfaces", "launch", "messages", "sim", "serve"),
}
_MODULES = {
    "import": "import_",
    **dict.fromkeys(("new", "edit"), "project"),
    **dict.fromkeys(("check", "fmt", "apply"), "task"),
    "replay": "runs",
    "interfaces": "component",
    "sim": "launch",
    **dict.fromkeys(("help", "completion"), "shell"),
}
"""Where it isn't the module of the verb's own name."""


def make_parser(words: Sequence[str] = (), shown: Collection[str] = FIRST) -> argparse.ArgumentParser:
    """Return the command's parser with all verbs, of which some are shown, and the options of the one that is named."""
    about = "Draw, run and measure robot grasping tasks: one graph, behaviour tree or state machine."
    more = "`grip help all` lists all verbs, `grip help VERB` says how one is used, `grip docs` opens the manual."
    more += " Exit status: 0 done, 1 wrong input, 2 usage, 3 a task failed, 4 error in a node or process, 130 stopped."
    parser = Parser(prog="grip", usage="grip [-h] [--version] VERB ...", description=about, epilog=more)
    parser.add_argument("--version", action="version", version=f"grip {__version__}")
    _add_loudness(parser)
    subparsers = parser.add_subparsers(prog="grip", metavar="VERB", required=True, help=argparse.SUPPRESS)
    named = next((word for word in words if not word.startswith("-")), None)
    for verb, doc in VERBS.items():
        options = subparsers.add_parser(verb, help=doc) if verb in shown else subparsers.add_parser(verb)
        if verb == named:
            module = import_module(f"grip_bt.cli.{_MODULES.get(verb, verb)}")
            options.set_defaults(usage_error=options.error, run=getattr(module, f"run_{verb}", None))
            getattr(module, f"add_{verb}")(options)
            for each in (options, *actions_of(options).values()):
                _add_loudness(each)
    listed = {line.dest: line for line in subparsers._choices_actions}
    for title, verbs in GROUPS.items():
        parser.add_argument_group(title)._group_actions = [listed[verb] for verb in verbs if verb in listed]
    subparsers._choices_actions = []
    return parser


def actions_of(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parsers of a verb's actions, such as `add` of `component`."""
    return {
        name: each
        for action in parser._actions
        if isinstance(action, argparse._SubParsersAction)
        for name, each in action.choices.items()
    }


def _add_loudness(parser: argparse.ArgumentParser) -> None:
    add, unless = partial(parser.add_argument, action="store_true"), argparse.SUPPRESS
    add("-q", "--quiet", default=unless, help="print results and errors only")
    add("-v", "--verbose", default=unless, help="also print what is logged, and where an error was raised")


def add_help(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("verb", nargs="?", choices=(*VERBS, "all"), metavar="VERB", help="a verb, or all")


def run_help(args: argparse.Namespace) -> int:
    if args.verb in (None, "all"):
        make_parser(shown=VERBS if args.verb else FIRST).print_help()
        return 0
    return _done([args.verb, "--help"])


def run_verb(arguments: Sequence[str] | None) -> int:
    """Run the verb of a command line and return the exit status; what goes wrong is said on stderr."""
    ready()
    try:
        status = _done(arguments)
        sys.stdout.flush()  # here, where what keeps it from being written can be said
        return status
    except NodeError as error:
        return complain(str(error), NODE_ERROR)
    except GripError as error:
        if terminal.verbose:
            traceback.print_exc()
        if getattr(error, "issues", None):
            print(error, file=sys.stderr)
            return INVALID
        return complain(str(error))
    except ModuleNotFoundError as error:
        if not (remedy := remedy_of(error)):
            raise
        return complain(str(MissingPartError(repr(error.name), remedy)))
    except BrokenPipeError:
        # The reader went away (`grip ... | head`): nothing more can be said, and nothing is wrong.
        give_up()
        return 0
    except OSError as error:
        return _refused_by_the_system(error)


def _done(arguments: Sequence[str] | None) -> int:
    try:
        words = (sys.argv[1:] if arguments is None else arguments) or ["--help"]
        args, strange = make_parser(words).parse_known_args(words)
        if strange:
            args.usage_error(f"unrecognized arguments: {' '.join(strange)}")
    except SystemExit:
        sys.stdout.flush()  # the help, which argparse has printed
        raise
    terminal.quiet, terminal.verbose = getattr(args, "quiet", False), getattr(args, "verbose", False)
    if terminal.verbose:
        logging.basicConfig(level=logging.DEBUG, format="%(name)s: %(message)s")
    if getattr(args, "no_code", False):
        from grip_bt.app.project.foreign_code import forbid

        forbid()
    return int(args.run(args) or 0)


def _refused_by_the_system(error: OSError) -> int:
    """Say which file or folder can't be read or written, and why; any other such error is a bug of ours."""
    if error.filename is None:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise error
        give_up()
        advice = "the output is incomplete: redirect it elsewhere, or free some space"
        return complain(f"stdout: {error.strerror}; {advice}")
    name = str(error.filename) if isinstance(error.filename, int) else os.fsdecode(error.filename)
    if error.errno == errno.ENOENT:
        return complain(f"{name}: {error.strerror}; make its folder first, or name another place")
    return complain(f"{name}: {error.strerror}; name another place, or change its permissions")


def add_completion(parser: argparse.ArgumentParser) -> None:
    kept = "keep what it prints where the shell looks for it, see `grip docs installing`, or source it"
    parser.add_argument("shell", choices=("bash", "zsh", "fish"), help=kept)


def run_completion(args: argparse.Namespace) -> None:
    first = "autoload -U +X bashcompinit && bashcompinit\n" if args.shell == "zsh" else ""
    kind = "fish" if args.shell == "fish" else "bash"
    put(first + Path(__file__).with_name(f"completion.{kind}").read_text(encoding="utf-8"))
