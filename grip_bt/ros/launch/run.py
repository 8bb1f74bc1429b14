"""Which way a launch file is run here: by `ros2 launch`, or by our own reader."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TextIO

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
    launch = read_launch_file(path, arguments, env=env)
    return launch.processes, launch.events


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
