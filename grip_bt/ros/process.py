"""Somebody else's process: what runs it, started in a group of its own, logged, and certain to die with us.

A process reaper (`grip_bt.ros.process_reaper`) stands between: it ends the whole group when we ask
for it and when we vanish.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from grip_bt.base.failures import ExpectedError, IncompatibleServerError
from grip_bt.base.operation import Operation
from grip_bt.base.xml import parse_xml
from grip_bt.ros import process_reaper
from grip_bt.ros.interfaces.packages import (
    PackageError,
    child_paths,
    executable_of,
    launch_file_in,
    launch_file_of,
)
from grip_bt.task.catalog.component_file import ComponentFile, Start

_PATIENCE = 3.5
"""How long the process reaper may take to end the group [s]."""
PYTHON = "{python}"
"""In a command, or an argument of a launch file: the Python that runs us, with ROS and the built interfaces."""
_OURS = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "ROS_PYTHON_CHECK_FIELDS")


class Process:
    """A command that runs until it ends or is stopped.

    Args:
        log: file that takes what it prints; its folder is made.
        again: says whether it is started again after it ended by itself.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        folder: Path,
        env: Mapping[str, str],
        log: Path,
        again: Start | None = None,
    ):
        self.name, self.command, self.log = name, tuple(command), log
        self._folder, self._env, self._again, self._starts = folder, dict(env), again, 0
        self._lock, self._stopping = threading.Lock(), threading.Event()
        self._broke: list[Callable[[], object]] = []
        log.parent.mkdir(parents=True, exist_ok=True)
        self._start()
        self._end: Operation[int] = Operation()
        threading.Thread(target=self._watch, name=f"process-{name}", daemon=True).start()

    def _start(self) -> None:
        with self.log.open("ab" if self._starts else "wb") as output:
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-S", str(Path(process_reaper.__file__).resolve()), *self.command],
                cwd=self._folder,
                env=self._env,
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self._starts += 1

    @property
    def alive(self) -> bool:
        """Whether it runs or is about to be started again."""
        return not self._end.done()

    @property
    def pid(self) -> int:
        """The process id of the process reaper; it leads the session of everything below."""
        return self._popen.pid

    @property
    def returncode(self) -> int | None:
        """The exit status (128 + number for a signal), None while it runs."""
        return self._popen.poll()

    def when_broken(self, callback: Callable[[], object]) -> None:
        """Call `callback()`, from another thread, each time that it ended by itself and will be started again."""
        self._broke.append(callback)

    def when_ended(self, callback: Callable[[], object]) -> None:
        """Call `callback()` when it has ended for good, from another thread; at once if it has."""
        self._end.add_done_callback(callback)

    def stop(self) -> None:
        """End the whole group and wait for it, at most some seconds; harmless when it has ended."""
        self.ask_to_stop()
        if not self._end.wait(_PATIENCE):
            self._popen.kill()  # the command dies with the process reaper
            self._end.wait(1.0)

    def ask_to_stop(self) -> None:
        """Begin to end the group, without waiting."""
        with self._lock:
            self._stopping.set()
            self._end_group()

    def _end_group(self) -> None:
        assert self._popen.stdin is not None
        self._popen.stdin.close()

    def log_tail(self, lines: int = 12) -> str:
        """Return the last lines that it printed."""
        try:
            text = self.log.read_bytes()[-8192:].decode("utf-8", "replace")
        except OSError:
            return ""
        return "\n".join(text.strip().splitlines()[-lines:])

    def describe_end(self) -> str:
        """Return how it ended and what it printed last, for an error message."""
        tail = self.log_tail()
        said = f"; its last output ({self.log}):\n{tail}" if tail else f"; it printed nothing ({self.log})"
        again = f"; start {self._starts + 1} follows" if self.alive else ""
        often = f" after {self._starts} starts" if self._starts > 1 and not again else ""
        return f"the process {self.name!r} ended with status {self.returncode}{often}{again}{said}"

    def _watch(self) -> None:
        status = self._popen.wait()
        self._end_group()
        again = self._again
        while again is not None and again.again(status != 0, self._starts) and not self._stopping.is_set():
            for callback in self._broke:
                callback()
            self._stopping.wait(again.restart_delay)
            with self._lock:
                if self._stopping.is_set():
                    break
                self._start()
            status = self._popen.wait()
            self._end_group()
        self._end.succeed(status)


def stop_all(processes: Sequence[Process]) -> None:
    """End several processes at once."""
    for process in processes:
        process.ask_to_stop()
    for process in processes:
        process.stop()


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
