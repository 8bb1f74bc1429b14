"""What is run for a `start` of a file (command, program of a package, launch file), and what to do when it fails."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

from grip_bt.base.errors import listing, nearest
from grip_bt.base.failures import ExpectedError, UnfitServerError
from grip_bt.base.interpreter import python_command
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.component_parts import Start

from .interfaces.ament import PackageError, executable_of, launch_file_of


def command_of(start: Start, folder: Path) -> list[str]:
    """Return program and arguments.

    Args:
        start: how it is started.
        folder: where relative launch files are.

    Raises:
        PackageError: the package, its program or its launch file isn't here.
    """
    if start.launch is not None:
        file = launch_file_of(start.package, start.launch) if start.package else _beside(folder, start.launch)
        return launch_command(file, {name: text_of(value) for name, value in start.arguments.items()})
    if start.executable is not None:
        return [str(executable_of(str(start.package), start.executable)), *start.args]
    return [word.replace("{python}", sys.executable) for word in start.command]


def _beside(folder: Path, name: str) -> Path:
    file = folder / name
    if file.is_file():
        return file
    known = [path.relative_to(folder).as_posix() for path in sorted(folder.glob("**/*launch*")) if path.is_file()]
    has = listing(known)
    raise PackageError(f"there is no launch file {name!r} in {folder}{nearest(name, known)} (there are: {has})")


def launch_command(file: Path, arguments: dict[str, str]) -> list[str]:
    """Return what runs a launch file: ROS's own `ros2 launch` where there is one, else `grip launch`."""
    given = [f"{name}:={value}" for name, value in arguments.items()]
    ros2 = shutil.which("ros2")
    if ros2 is not None:
        return [ros2, "launch", str(file), *given]
    return python_command("-m", "grip_bt.cli", "launch", str(file), *given)


def text_of(value: str | bool | int | float) -> str:
    """Return a value as launch files spell it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def uses_our_python(start: Start) -> bool:
    """Tell whether our own Python runs it, so that interfaces built for it may be put on its path."""
    return any("{python}" in word for word in start.command)


_MISSING = re.compile(r"No module named '(\w+)'")


def advice(file: ComponentFile, error: ExpectedError, alive: bool, said: str) -> str:
    """Return what to do, to be put behind an error's message; empty where the message says it.

    Args:
        file: the component.
        error: why there is no server.
        alive: whether a process of ours runs that should serve it.
        said: what that process printed last.
    """
    starts = file.start is not None and file.start.run
    if isinstance(error, UnfitServerError):
        return _about_type(file, str(error.data.get("serves", "")))
    if "waited" not in error.data:
        return _about_end(file, said) if starts else ""
    if not starts:
        off = (
            "remove `run: false` from its `start`" if file.start is not None else "say under `start` how it is started"
        )
        return f". Start it, or {off} (component.yaml of {file.name})"
    if alive:
        return (
            f". Its process runs: does it serve {file.server} (`server`), as {file.interface} (`interface`), and in "
            "time (`timeouts: {ready: SECONDS}`)?"
        )
    return ""


def _about_type(file: ComponentFile, serves: str) -> str:
    if not serves or serves == file.interface:
        return ""
    return (
        f". If that is meant: `interface: {serves}` in component.yaml of {file.name}, then `grip component add` again"
    )


def _about_end(file: ComponentFile, said: str) -> str:
    """Return what to do about a process that ended instead of serving."""
    assert file.start is not None
    program = file.start.command[0] if file.start.command else ""
    missing = _MISSING.search(said)
    if missing is None:
        return "" if said else "\nA server runs until it is stopped; this one ended by itself."
    own = missing[1] in ("rclpy", "std_msgs", "std_srvs", file.interface.partition("/")[0])
    if own and program and not uses_our_python(file.start):
        return (
            f"\n{program!r} is a Python without ROS or the built interfaces: write "
            '"{python}" in `command` for the one that runs GRIP, or name one that has them'
        )
    return (
        f"\n{missing[1]!r} isn't installed for the Python that runs it: install it there, or name another in `command`"
    )
