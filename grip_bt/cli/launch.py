"""`grip launch`: a launch file, or the processes of a project; `grip sim`: a simulated world as a ROS 2 robot."""

from __future__ import annotations

import argparse
import shlex
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from grip_bt.app.project.folder import FILE_NAME, Project, find_project
from grip_bt.app.project.foreign_code import refuse
from grip_bt.app.project.launching import launch_file_of, project_members
from grip_bt.app.wiring.parts import load_part
from grip_bt.base.errors import GripError
from grip_bt.cli import NODE_ERROR, STOPPED
from grip_bt.cli.parser import add_no_code, number
from grip_bt.cli.signals import on_stop
from grip_bt.cli.terminal import complain, progress, tell
from grip_bt.ros.process_group import Member, ProcessGroup, member_of
from grip_bt.task.catalog.start import ProcessConfig

SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".launch", ".xml", ".yaml", ".yml", ".py")


def add_launch(parser: argparse.ArgumentParser) -> None:
    what = "a launch file with NAME:=VALUE ..., or processes of the project (default: all of them)"
    parser.add_argument("what", nargs="*", metavar="FILE|NAME", help=what)
    parser.add_argument("--project", type=Path, default=Path(), help="project folder (default: here)")
    parser.add_argument("--follow", action="store_true", help="print what the processes print")
    parser.add_argument("--check", action="store_true", help="start nothing; print what would be run")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the project as a ROS 2 launch file (.xml)")
    parser.add_argument("--json", action="store_true", help="with --check: one JSON list")
    add_no_code(parser)


def run_launch(args: argparse.Namespace) -> int:
    """Run until all have ended, a required one has failed, or we are told to stop."""
    if args.write is not None:
        args.write.write_text(launch_file_of(find_project(args.project), args.write.parent), encoding="utf-8")
        print(f"{args.write}: run it by `ros2 launch {args.write}` or `grip launch {args.write}`")
        return 0
    project, members = _members(args)
    if args.check:
        lines = [f"{m.name}: {shlex.join(m.command)}" for m in members]
        tell(args.json, [{"name": m.name, "command": list(m.command)} for m in members], lines)
        return 0
    if not members:
        file = project.folder / FILE_NAME
        said = "declares no processes; " if file.is_file() else "doesn't exist; pass --project, "
        raise GripError(f"{file} {said}name a launch file, or add `processes:`")
    refuse(f"{member.name}: starts {shlex.join(member.command)}" for member in members)
    return _supervise(members, project.state_folder / "logs" / "launch", args.follow)


def _members(args: argparse.Namespace) -> tuple[Project, list[Member]]:
    project = find_project(args.project)
    if args.what and args.what[0].endswith(SUFFIXES):
        file, found = Path(args.what[0]), dict[str, str]()
        if not file.is_file():
            raise GripError(f"{file}: there is no such file")
        for word in args.what[1:]:
            name, sign, value = word.partition(":=")
            if not sign or not name:
                raise GripError(f"{word!r} isn't an argument of a launch file: NAME:=VALUE")
            found[name] = value
        return project, [member_of(file.name, ProcessConfig(launch=str(file), arguments=found), Path.cwd())]
    return project, project_members(project, args.what)


def _supervise(members: Sequence[Member], logs: Path, follow: bool) -> int:
    stopped = threading.Event()

    def tell_state(name: str, state: str, detail: str) -> None:
        first = f": {detail.splitlines()[0]}" if detail else ""
        print(f"  {name:<20} {state}{first}", file=sys.stderr, flush=True)

    group = ProcessGroup(members, logs, on_change=tell_state, output=sys.stdout if follow else None)

    def stop() -> None:
        stopped.set()
        group.ask_to_stop()

    on_stop(stop)
    group.start()
    why = group.run()
    if stopped.is_set():
        return STOPPED
    return complain(why, NODE_ERROR) if why else 0


def add_sim(parser: argparse.ArgumentParser) -> None:
    add, positive = parser.add_argument, number(above=0)
    add("world", nargs="?", help="which world (default: the project's, else table)")
    add("--project", type=Path, default=Path(), metavar="DIR", help="whose robot (default: here)")
    add("--seed", type=int, default=0, help="of the world (default: 0)")
    add("--pace", type=positive, default=1.0, metavar="X", help="playback speed: simulated seconds a second")
    add("--camera-rate", type=positive, default=2.0, metavar="HZ", help="frames a second while somebody subscribes")
    add("--room", type=Path, metavar="FILE", help="write the world's fixed objects to a .scene file, for planners")
    add("--simulated-time", action="store_true", help="publish /clock, and stamp everything with simulated time")
    add("--setup", type=Path, metavar="FILE", help="write a setup.bash, by which other shells find the interfaces")


def run_sim(args: argparse.Namespace) -> int:
    over = threading.Event()
    on_stop(over.set)
    project = find_project(args.project)
    serving = load_part("ros_simulation", "the simulator or ROS", "sim,ros")
    rate, simulated = args.camera_rate, args.simulated_time
    world = args.world or project.file.world or "table"
    with serving.serve_world(project, world, args.seed, args.pace, progress, rate, simulated) as served:
        if args.setup is not None:
            args.setup.write_text(served.setup)
        if args.room is not None:
            args.room.write_text(served.room)
        print("\nFor `grip run TASK --robot ros`, put this into grip.yaml:\n")
        tell(False, ({} if args.room is None else {"scene": str(args.room)}) | served.settings)
        print("\nserving; press Ctrl-C to stop", flush=True)
        while not over.wait(0.5):
            try:
                served.simulation.referee.fingerprint()
            except GripError as error:
                return complain(str(error), NODE_ERROR)
        for name, truth in served.simulation.referee.truth().items():
            print(f"{name}: {truth.status}")
    return 0
