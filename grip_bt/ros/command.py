"""What somebody else's process is started with: its command, its environment; and what to do when it serves nothing."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from grip_bt.base.failures import ExpectedError, IncompatibleServerError
from grip_bt.base.xml import parse_xml
from grip_bt.ros.interfaces.packages import PackageError, child_paths, executable_of, launch_file_in, launch_file_of
from grip_bt.ros.process import Process
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.start import Start

PYTHON = "{python}"
"""In a command, or an argument of a launch file: the Python that runs us, with ROS and the built interfaces."""
_OURS = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "ROS_PYTHON_CHECK_FIELDS")


def child_environment(
    overlays: Sequence[Path] = (), domain_id: int | None = None, more: Mapping[str, str] = MappingProxyType({})
) -> dict[str, str]:
    """Return the environment for a process that we start.

    What belongs to this very interpreter is taken out: the wheels' guard variable and library folders would make
    another Python load our libraries (its own wheels add theirs again). Discovery range and DDS profile are those that
    `prepare` has set.

    Args:
        overlays: prefixes whose interface packages the process may import; only for our own Python.
        domain_id: the DDS domain; this process's by default.
        more: further variables; a search path, such as PYTHONPATH, comes before what is there.
    """
    env = {k: v for k, v in os.environ.items() if k not in _OURS}
    folders = [Path(p) for p in env.get("LD_LIBRARY_PATH", "").split(os.pathsep)]
    bundled = [p for p in folders if p == Path(sys.prefix) / "lib" or (p.name[:4], p.suffix) == ("ros_", ".libs")]
    _put(env, "LD_LIBRARY_PATH", (), bundled)
    for variable, folders in child_paths(overlays).items():
        _put(env, variable, folders, folders)
    if domain_id is not None:
        env["ROS_DOMAIN_ID"] = str(domain_id)
    env["PYTHONUNBUFFERED"] = "1"  # or the last words of a process that dies are lost
    before = {name: f"{os.pathsep}{env[name]}" for name in more if name.endswith("PATH") and env.get(name)}
    return env | {name: value + before.get(name, "") for name, value in more.items()}


def _put(env: dict[str, str], variable: str, first: Sequence[Path], but: Collection[Path]) -> None:
    """Put folders in front of a search path, without some that it has."""
    rest = [p for p in env.pop(variable, "").split(os.pathsep) if p and Path(p) not in but]
    if first or rest:
        env[variable] = os.pathsep.join([*map(str, first), *rest])


def command_of(start: Start, folder: Path) -> list[str]:
    """Return program and arguments.

    Args:
        folder: where relative launch files are.

    Raises:
        PackageError: the package, its program, its launch file or `ros2 launch` isn't here.
    """
    if start.launch is not None:
        file = launch_file_of(start.package, start.launch) if start.package else launch_file_in(folder, start.launch)
        given = {name: text_of(value).replace(PYTHON, sys.executable) for name, value in start.arguments.items()}
        ros2 = shutil.which("ros2")
        if ros2 is None:
            return program_of(file, given)
        return [ros2, "launch", str(file), *(f"{name}:={value}" for name, value in given.items())]
    scope = ("--ros-args", "-r", f"__ns:={start.namespace}") if start.namespace else ()
    if start.executable is not None:
        return [str(executable_of(str(start.package), start.executable)), *start.args, *scope]
    return [word.replace(PYTHON, sys.executable) for word in (*start.command, *scope)]


def text_of(value: object) -> str:
    """Return a value as launch files spell it."""
    return str(value).lower() if isinstance(value, bool) else "" if value is None else str(value)


def start_process(
    name: str, start: Start | None, folder: Path, log: Path, domain_id: int | None, overlays: Sequence[Path] = ()
) -> Process | None:
    """Start what a file declares in its folder; None where that is expected to run.

    Args:
        overlays: interfaces that were built for our own Python; put on the path of what that runs.
    """
    if start is None or not start.run:
        return None
    ours = any(PYTHON in word for word in (*start.command, *map(text_of, start.arguments.values())))
    env = child_environment(overlays if ours else (), domain_id, start.env)
    return Process(name, command_of(start, folder), folder, env, log, start)


_MISSING = re.compile(r"No module named '(\w+)'")


def advice(file: ComponentFile, error: ExpectedError, alive: bool, said: str) -> str:
    """Return what to do, to be put behind an error's message; empty where the message says it.

    Args:
        error: why there is no server.
        alive: whether a process of ours runs that should serve it.
    """
    start, home = file.start, f"component.yaml of {file.name}"
    if isinstance(error, IncompatibleServerError):
        serves = str(error.data.get("serves", "")) or file.interface
        meant = f"`interface: {serves}` in {home}, then `grip component add` again"
        return "" if serves == file.interface else f". If that is meant: {meant}"
    if start is None or not start.run:
        how = f"Start it, or say under `start` how it is started, without `run: false` ({home})"
        return f". {how}" if "waited" in error.data else ""
    if "waited" in error.data:
        asked = f"does it serve {file.server} (`server`), as {file.interface} (`interface`), and in time"
        return f". Its process runs: {asked} (`timeouts: {{ready: SECONDS}}`)?" if alive else ""
    if missing := _MISSING.search(said):
        ours = "`{python}` is the one that runs GRIP, with ROS and the built interfaces"
        return f"\n{missing[1]!r} isn't installed for the Python in `command` ({home}); {ours}"
    return "" if said else "\nA server runs until it is stopped; this one ended by itself."


_VARIABLE, _PLACE = re.compile(r"\$\(var +(\w+)\)"), re.compile(r"\$\((\w+)\)")


def program_of(file: Path, given: Mapping[str, str]) -> list[str]:
    """Return the command of an `.xml` launch file that has arguments and one `<executable cmd=...>`.

    Raises:
        PackageError: it has something else, which takes `ros2 launch`, or an argument lacks its value.
        DocumentError: it is no XML.
    """
    elements = list(parse_xml(file.read_bytes(), str(file))) if file.suffix == ".xml" else []
    programs = [element for element in elements if element.tag == "executable"]
    if len(programs) != 1 or not {element.tag for element in elements} <= {"arg", "executable"}:
        how = "source a ROS that has it (source /opt/ros/jazzy/setup.bash), or say what to start by `command:`"
        raise PackageError(f"{file}: launch files are run by `ros2 launch`, which isn't on the path; {how}")
    known = {each.get("name", ""): each.get("default") for each in elements if each.tag == "arg"} | dict(given)
    if lacking := sorted(name for name, value in known.items() if value is None):
        raise PackageError(f"{file}: its argument {lacking[0]!r} has no value; give one under `arguments:`")
    values = {"dirname": str(file.parent), **{f"var_{name}": str(value) for name, value in known.items()}}
    words = shlex.split(_VARIABLE.sub(r"$(var_\1)", programs[0].get("cmd", "")))
    return [_PLACE.sub(lambda at: values.get(at[1], at[0]), word) for word in words]
