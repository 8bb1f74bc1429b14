"""`grip new` makes a project, `grip edit` shows its tasks in a browser."""

from __future__ import annotations

import argparse
import shlex
import signal
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from grip_bt.app.project.folder import FILE_NAME, find_project, in_world, make_project, ros_files
from grip_bt.app.project.foreign_code import refuse
from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.base.files import replace_text
from grip_bt.cli.parser import STAND_INS, add_no_code
from grip_bt.cli.signals import on_hang_up
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.formats.pytrees import import_from_code
from grip_bt.nodes.tree_code import is_tree_code, place_of
from grip_bt.task import dumps
from grip_bt.task.validation.parts import DRAWN, STOOD_IN
from grip_sim.worlds import world_files

DEFAULT = "panda_allegro"
"""The robot of a project that names none."""
BENCH = "bench, with something to take"
TASKS = ("tasks/take.yaml", "tasks/first.yaml")
"""What a new project may have, the most telling one first."""


def add_new(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="a new or empty folder")
    robot = "a ready-made robot, a robot's file, a MoveIt package or its name, a workspace (default: panda_allegro)"
    parser.add_argument("--robot", metavar="PATH|NAME", help=robot)
    world = "a built-in world, see `grip world list` (default: a bench with something to take, where an arm can)"
    parser.add_argument("--world", metavar="NAME", help=world)
    which = "which one, where the robot has several"
    parser.add_argument("--configuration", metavar="NAME", action="append", default=[], help=which)
    parser.add_argument("--ros", action="store_true", help="make it a ROS package too, which colcon builds")


def run_new(args: argparse.Namespace) -> None:
    files = ros_files(Path(args.folder)) if args.ros else {}
    if args.world not in (None, *world_files()):
        raise UnknownNameError("world", args.world, world_files())
    if args.robot is None and args.world is None and sys.stdin.isatty() and sys.stdout.isatty():
        robot = _chosen([], "the robot", [DEFAULT, *(name for name in ROBOTS if name != DEFAULT)])
        world = _chosen([], "the world", [BENCH, *world_files()])
        args.robot, args.world = None if robot == DEFAULT else robot, None if world == BENCH else world
    files |= _files_of_robot(args) if args.robot is not None else in_world(args.world) if args.world else {}
    written = make_project(args.folder, files)
    print(f"{args.folder}: {', '.join(str(file) for file in written)}")
    folder, first = shlex.quote(args.folder), next(task for task in TASKS if Path(task) in written)
    print(f"next: grip run {folder}/{first} --robot fake, --robot sim, or `grip edit {folder}`")


def _files_of_robot(args: argparse.Namespace) -> dict[str, str]:
    from grip_bt.app.project.new_robot import new_robot  # it takes the extra `motion`

    choose = partial(_chosen, args.configuration)
    made = new_robot(args.robot, Path(args.folder), choose, by_package=args.ros, world=args.world)
    told = {finding.code: finding for finding in reversed(made.findings)}
    for finding in told.values():
        count = sum(other.code == finding.code for other in made.findings)
        print(f"{finding}{f' (and {count - 1} more like it)' if count > 1 else ''}")
    return dict(made.files)


def _chosen(given: list[str], question: str, names: Sequence[str]) -> str:
    """Return what `--configuration` names, what is answered at a terminal, or the first, which is said."""
    for name in given:
        if name in names:
            return name
    if given and not any("/" in name for name in names):
        raise UnknownNameError("configuration", given[-1], names)
    if sys.stdin.isatty() and sys.stdout.isatty():
        for number, name in enumerate(names, 1):
            print(f"{number:3}  {name}")
        answer = input(f"{question}; which one? [1] ").strip() or "1"
        if answer.isdigit() and 0 < int(answer) <= len(names):
            return names[int(answer) - 1]
        return _chosen([answer], question, names)
    print(f"{question}: {names[0]} is taken; others, for --configuration: {', '.join(names[1:])}")
    return names[0]


def add_edit(parser: argparse.ArgumentParser) -> None:
    path = "a project folder or a task file (default: here); with --execute, code that makes a tree of py_trees"
    parser.add_argument("path", nargs="?", default=".", type=Path, help=path)
    parser.add_argument("--execute", action="store_true", help="run that code to draw its tree, if you trust it")
    parser.add_argument("--stand-ins", action="store_true", help=f"--execute: {STAND_INS}")
    parser.add_argument("--port", type=int, default=0, help="port on this machine (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument("--study", metavar="CSV", type=Path, help="add up there how long what had the focus [s]")
    add_no_code(parser)


def run_edit(args: argparse.Namespace) -> int:
    from grip_gui.server import serve  # here, since `grip edit --help` needs no extra

    if args.execute:
        args.path = drawing_of(str(args.path), args.stand_ins)
    elif is_tree_code(str(args.path)) and not args.path.exists():
        raise GripError(f"{args.path}: its tree is drawn by running it; if you trust it, say so with --execute")
    if not args.path.exists():
        raise DocumentError("does not exist; give a project folder or a task file", str(args.path))
    on_hang_up(lambda: signal.raise_signal(signal.SIGINT))  # the server obeys that
    task = args.path if args.path.is_file() and args.path.name != "grip.yaml" else None
    return serve(args.path, task=task, port=args.port, open_browser=not args.no_browser, study=args.study)


def drawing_of(where: str, stand_ins: bool) -> Path:
    """Write the task that draws somebody's tree, in a project of its own that may run it; return its file."""
    refuse([f"--execute: imports and runs {where}"])
    place = place_of(where)
    task = import_from_code(where, Path.cwd(), as_it_is=True, stand_ins=stand_ins).task
    name = f"{place.import_name}.{place.name}"
    folder = find_project(place.file or Path.cwd()).state_folder / "trees" / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / FILE_NAME).write_text(f"grip: 1\ncode: ['{place.import_name}:{place.name}']\n", encoding="utf-8")
    source = where if place.file is None else str(place.file.resolve()) + where.removeprefix(str(place.file))
    drawing = task.model_copy(update={"x": {**task.x, DRAWN: source, **({STOOD_IN: True} if stand_ins else {})}})
    file = folder / f"{place.name}.yaml"
    replace_text(file, f"# What {where} builds; a run of this runs that.\n{dumps(drawing)}")
    return file
