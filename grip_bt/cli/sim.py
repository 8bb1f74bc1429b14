"""`grip sim`: a simulated world as a ROS 2 robot."""

from __future__ import annotations

import argparse
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring.parts import load_part
from grip_bt.base.errors import GripError

from .parser import number
from .terminal import on_stop, progress

if TYPE_CHECKING:
    from grip_bt.app.wiring.ros_simulation import Served

if TYPE_CHECKING:
    from grip_bt.app.wiring.ros_simulation import Served

STOPPED, SIMULATOR_ENDED = 0, 4


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("world", nargs="?", default="table", help="which world (default: table)")
    parser.add_argument("--project", type=Path, default=Path(), metavar="DIR", help="whose robot (default: here)")
    parser.add_argument("--seed", type=int, default=0, help="of the world (default: 0)")
    parser.add_argument(
        "--pace", type=number(above=0), default=1.0, metavar="X", help="playback speed: simulated seconds a second"
    )
    parser.add_argument(
        "--camera-rate", type=number(above=0), default=2.0, metavar="HZ", help="frames a second, while somebody listens"
    )
    parser.add_argument(
        "--room", type=Path, metavar="FILE", help="write what stands in the world, as a .scene file for planners"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serve the world until Ctrl-C; then say where its objects are."""
    over = threading.Event()
    on_stop(over.set)
    project = find_project(args.project)
    serving = load_part("ros_simulation", "the simulator or ROS", "sim,ros")
    with serving.serve_world(project, args.world, args.seed, args.pace, progress, args.camera_rate) as served:
        if args.room is not None:
            args.room.write_text(served.room)
        print(_settings(served, args.room), flush=True)
        while not over.wait(0.5):
            try:
                served.simulation.referee.fingerprint()
            except GripError as error:
                print(f"grip: {error}")
                return SIMULATOR_ENDED
        for name, truth in served.simulation.referee.truth().items():
            print(f"{name}: {truth.status}")
    return STOPPED


def _settings(served: Served, room: Path | None) -> str:
    """Return what `grip.yaml` says to reach it."""
    lines = ["", "serving; Ctrl-C ends it. For `grip run TASK --robot ros`, grip.yaml says:", ""]
    if room is not None:
        lines.append(f"scene: {room}")
    lines += ["ros:", f"  joint_states: {served.joints}", "  controllers:"]
    lines += [f"    {name}: {{trajectory: {action}}}" for name, action in served.controllers.items()]
    if served.cameras:
        lines.append("  cameras:")
    for name, topics in served.cameras.items():
        lines += [f"    {name}:", *(f"      {part}: {topics[part]}" for part in ("image", "depth", "info"))]
        mount = ", ".join(f"{key}: {value}" for key, value in served.mounts[name].items())
        lines.append(f"      mount: {{{mount}}}")
    return "\n".join([*lines, ""])
