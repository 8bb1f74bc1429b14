"""Which way a launch file is run here: by `ros2 launch`, by ROS's `launch` package, or by our own reader."""

from __future__ import annotations

import importlib.util
import shutil
import sys
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TextIO

from grip_bt.base.interpreter import python_command

from ..process import child_environment
from .element import LaunchError
from .group import LaunchEvent, Member, ProcessGroup
from .interpreter import read_launch_file

SUFFIXES = (".launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".launch", ".xml", ".yaml", ".yml", ".py")


def is_launch_file(name: str) -> bool:
    """Tell whether a name is that of a launch file."""
    return name.endswith(SUFFIXES)


def members_of_file(
    path: Path, arguments: Mapping[str, str], own_reader: bool = False
) -> tuple[list[Member], list[LaunchEvent]]:
    """Return the processes that run a launch file, and what else happens in it.

    With ROS's tools there is one, which sees to all others; without them, one for each node and executable.

    Args:
        path: the file.
        arguments: values of its arguments.
        own_reader: whether our own reader is used also where ROS's tools are.

    Raises:
        LaunchError: the file can't be run here; it says why, and what to do.
    """
    if not path.is_file():
        raise LaunchError(str(path), None, "there is no such file")
    env = child_environment(())
    given = [f"{name}:={value}" for name, value in arguments.items()]
    ros2 = None if own_reader else shutil.which("ros2")
    if ros2 is not None:
        return [Member(path.name, [ros2, "launch", str(path), *given], Path.cwd(), env)], []
    if path.suffix == ".py" and has_launch_package():
        command = python_command("-m", "grip_bt.ros.launch.run", str(path), *given)
        return [Member(path.name, command, Path.cwd(), env)], []
    launch = read_launch_file(path, arguments, env=env)
    return launch.processes, launch.events


def has_launch_package() -> bool:
    """Tell whether ROS's own `launch` is importable; another project on PyPI has the same name."""
    spec = importlib.util.find_spec("launch")
    folders = list(spec.submodule_search_locations or ()) if spec is not None else []
    return any((Path(folder) / "launch_description_sources").is_dir() for folder in folders)


LOOK = 0.1
"""How often the logs are looked at [s]."""


class Follower:
    """Copies new lines of the logs of a group.

    Args:
        group: whose.
        names: of its members.
        output: where lines go, as `[name] line`.
    """

    def __init__(self, group: ProcessGroup, names: Sequence[str], output: TextIO):
        self._group, self._names, self._output = group, names, output
        self._read: dict[Path, int] = {}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="grip_follow", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Copy what is left, and end."""
        self._stop.set()
        self._thread.join(2.0)

    def _follow(self) -> None:
        while not self._stop.wait(LOOK):
            self._copy(last=False)
        self._copy(last=True)

    def _copy(self, last: bool) -> None:
        for name in self._names:
            log = self._group.log(name)
            if log is None or not log.is_file():
                continue
            with log.open("rb") as file:
                file.seek(self._read.get(log, 0))
                new = file.read()
            whole = new if last else new[: new.rfind(b"\n") + 1]
            self._read[log] = self._read.get(log, 0) + len(whole)
            for line in whole.decode("utf-8", "replace").splitlines():
                self._output.write(f"[{name}] {line}\n")
        self._output.flush()


def main(words: list[str]) -> int:
    """Run a file by ROS's own `launch` package until it ends; return its exit status: `FILE NAME:=VALUE ...`."""
    from launch import LaunchDescription, LaunchService
    from launch.actions import IncludeLaunchDescription
    from launch.launch_description_sources import AnyLaunchDescriptionSource

    file, *rest = words
    arguments = [tuple(word.split(":=", 1)) for word in rest]
    service = LaunchService(argv=rest)
    include = IncludeLaunchDescription(AnyLaunchDescriptionSource(file), launch_arguments=arguments)
    service.include_launch_description(LaunchDescription([include]))
    return int(service.run())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
