"""What is run for a `start` of a file: a command, a program of a ROS package, or a launch file."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from grip_bt.base.errors import listing, nearest
from grip_bt.base.interpreter import python_command
from grip_bt.task.catalog.component_parts import Start

from .packages import PackageError, executable_of, launch_file_of


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
