"""`grip serve`: a project's tasks as a ROS 2 node, an action and services."""

from __future__ import annotations

import argparse
from pathlib import Path

from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.served_tasks import ServedTasks
from grip_bt.ros.interfaces.build import shell_setup
from grip_bt.ros.task_server import serve_tasks

from .signals import on_hang_up


def add_serve(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("project", type=Path, nargs="?", default=Path(), metavar="DIR", help="project (default: here)")
    robot = "of goals that name none (default: ros)"
    parser.add_argument("--robot", choices=("ros", "sim", "fake"), default="ros", help=robot)
    parser.add_argument("--name", default="grip", help="of the node (default: grip)")
    setup = "write a setup.bash, by which other shells find the interfaces"
    parser.add_argument("--setup", type=Path, metavar="FILE", help=setup)
    managed = "wait for a life-cycle manager to configure and activate the node"
    parser.add_argument("--managed", action="store_true", help=managed)


def run_serve(args: argparse.Namespace) -> None:
    """Serve until a signal, or ROS, ends it."""
    project = find_project(args.project)
    tasks = ServedTasks(project, args.robot)
    if args.setup is not None:
        args.setup.write_text(shell_setup("grip_msgs"), encoding="utf-8")
    on_hang_up(lambda: None)

    def ready() -> None:
        state = "unconfigured" if args.managed else "active"
        print(f"serving {len(tasks.listed())} tasks of {project.folder} as /{args.name}/run_task: {state}", flush=True)

    serve_tasks(tasks, args.name, not args.managed, ready)
