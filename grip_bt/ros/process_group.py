"""Processes that belong together: started, watched until they are ready, started again, and ended all at once.

Each has a process reaper (`grip_bt.ros.process_reaper`): whatever becomes of us, nothing of the group is left behind.
What each prints goes into a file of its own.
"""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TextIO

from grip_bt.base.errors import GripError
from grip_bt.base.files import Closing
from grip_bt.task.catalog.start import ProcessConfig, Ready

from .command import child_environment, command_of
from .process import Process, stop_all

if TYPE_CHECKING:
    from .client.connection import Connection

State = Literal["waiting", "starting", "ready", "restarting", "silent", "ended", "failed", "stopped"]
LOOK = 0.1
"""How often the group is looked at [s]."""
SILENCE = 5.0
"""How long the service or topic of a process that was ready may be missing before it counts as silent [s]."""


@dataclass(frozen=True)
class Member:
    """What the group has to know of a process.

    Attributes:
        name: unique in the group.
        env: all of its environment.
        config: when it is ready, and what becomes of it when it ends by itself.
    """

    name: str
    command: Sequence[str]
    folder: Path
    env: Mapping[str, str]
    config: ProcessConfig


def member_of(name: str, config: ProcessConfig, folder: Path) -> Member:
    """Return a process in a folder. Raises PackageError: its package, program or launch file isn't here."""
    command, environment = command_of(config, folder), child_environment(more=config.env)
    return Member(name, command, folder / (config.folder or "."), environment, config)


@dataclass
class _Running:
    member: Member
    process: Process | None = None
    state: State = "waiting"
    began: float = 0.0
    starts: int = 0
    again_at: float = 0.0
    seen: float = 0.0
    why: str = ""
    logs: list[Path] = field(default_factory=list)
    copied: int = 0

    @property
    def failed(self) -> bool:
        """Whether it was given up; looked up anew, since another look may have found that."""
        return self.state == "failed"


class StartError(GripError):
    """A process of a group didn't become ready, or ended before; with the end of its log."""


Listener = Callable[[str, State, str], None]
"""Listener `(name, state, detail)`."""


class ProcessGroup(Closing):
    """Runs processes together.

    Args:
        members: the processes, in the order in which they are started; each waits until those before it are ready.
        domain_id: the DDS domain in which services and topics are looked for.
        output: where new lines of all logs are copied to, as `[name] line`; None for nowhere.
    """

    def __init__(
        self,
        members: Sequence[Member],
        logs: Path,
        domain_id: int | None = None,
        on_change: Listener = lambda name, state, detail: None,
        output: TextIO | None = None,
    ):
        self._all = {member.name: _Running(member) for member in members}
        self._logs, self._on_change, self._output = logs, on_change, output
        self._watch = GraphWatch(domain_id)
        self._lock = threading.RLock()
        self._stopping = threading.Event()

    def states(self) -> dict[str, State]:
        return {name: running.state for name, running in self._all.items()}

    def start(self) -> None:
        """Start all, each when those before it are ready.

        Raises:
            StartError: one isn't ready in time or ended before; all are ended again.
        """
        try:
            for running in self._all.values():
                if self._stopping.is_set():
                    return
                self._begin(running)
                self._until_ready(running)
        except BaseException:
            self.close()
            raise

    def run(self) -> str:
        """Watch over all until none is left, a required one is given up, or `ask_to_stop` is called.

        Returns:
            What failed; empty when nothing did.
        """
        try:
            while not self._stopping.wait(LOOK):
                for running in self._all.values():
                    self._look(running)
                failed = [r for r in self._all.values() if r.state == "failed"]
                if given_up := [r for r in failed if r.member.config.required]:
                    return given_up[0].why
                if all(r.state in ("ended", "failed") for r in self._all.values()):
                    return failed[0].why if failed else ""
            return ""
        finally:
            self.close()

    def close(self) -> None:
        """End all processes together, with all that they have started; at most 3 s."""
        self._stopping.set()
        with self._lock:
            stop_all([r.process for r in self._all.values() if r.process is not None])
            for running in self._all.values():
                self._copy(running)
                if running.state not in ("ended", "failed", "stopped", "waiting"):
                    self._set_state(running, "stopped", "")
            self._watch.close()

    def ask_to_stop(self) -> None:
        """Have `run` come to its end; may be called from a signal handler."""
        self._stopping.set()

    # --- one process ---

    def _begin(self, running: _Running) -> None:
        member = running.member
        running.starts += 1
        number = f".{running.starts}" if running.starts > 1 else ""
        name = re.sub(r"[^A-Za-z0-9_.-]", "_", member.name).strip(".") or "process"
        log = self._logs / f"{name}{number}.log"
        with self._lock:
            if self._stopping.is_set():
                return
            running.process = Process(member.name, member.command, member.folder, member.env, log)
        running.logs.append(log)
        running.copied = 0
        running.began = running.seen = time.monotonic()
        self._set_state(running, "starting", f"process {running.process.pid}, log {log}")
        if member.config.ready is None:
            self._set_state(running, "ready", "")

    def _until_ready(self, running: _Running) -> None:
        ready = running.member.config.ready
        while running.state == "starting" and not self._stopping.wait(LOOK / 2):
            self._look(running)
            if running.failed and running.member.config.required:
                raise StartError(running.why)
            if ready is not None and running.state == "starting" and time.monotonic() > running.began + ready.within:
                tail = running.process.log_tail() if running.process else ""
                said = f"; its log ({running.logs[-1]}) ends with:\n{tail}" if tail else "; it printed nothing"
                instead = self._watch.instead(ready)
                raise StartError(
                    f"{running.member.name}: {ready} wasn't there within {ready.within:g} s{instead}{said}"
                )

    def _look(self, running: _Running) -> None:
        process, now = running.process, time.monotonic()
        self._copy(running)
        if running.state == "restarting":
            if now >= running.again_at:
                self._begin(running)
        elif process is None or running.state in ("ended", "failed", "stopped"):
            return
        elif not process.alive:
            self._ended(running, process)
        elif running.state == "starting" and self._is_ready(running):
            self._set_state(running, "ready", f"after {now - running.began:.1f} s")
        elif running.state in ("ready", "silent"):
            self._check_health(running, now)

    def _copy(self, running: _Running) -> None:
        """Copy the whole lines that are new in a log, all of it when its process has ended."""
        if self._output is None or running.process is None:
            return
        over = not running.process.alive
        with running.logs[-1].open("rb") as file:
            file.seek(running.copied)
            new = file.read()
        whole = new if over else new[: new.rfind(b"\n") + 1]
        running.copied += len(whole)
        for line in whole.decode("utf-8", "replace").splitlines():
            self._output.write(f"[{running.member.name}] {line}\n")
        self._output.flush()

    def _is_ready(self, running: _Running) -> bool:
        ready = running.member.config.ready
        if ready is None:
            return True
        if ready.log is not None:
            text = running.logs[-1].read_text(encoding="utf-8", errors="replace")
            return re.search(ready.log, text, re.MULTILINE) is not None
        return self._watch.sees(ready)

    def _check_health(self, running: _Running, now: float) -> None:
        ready = running.member.config.ready
        if ready is None or ready.log is not None:
            return
        if self._watch.sees(ready):
            running.seen = now
            if running.state == "silent":
                self._set_state(running, "ready", "again")
        elif running.state == "ready" and now > running.seen + SILENCE:
            self._set_state(running, "silent", f"{ready} disappeared; the process is still running")
            if running.member.config.restart != "never" and running.process is not None:
                running.process.ask_to_stop()

    def _ended(self, running: _Running, process: Process) -> None:
        config, status = running.member.config, process.returncode
        failed = status != 0 or running.state == "silent"
        if config.again(failed, running.starts) and not self._stopping.is_set():
            running.again_at = time.monotonic() + config.restart_delay
            self._set_state(running, "restarting", f"ended with status {status}; start {running.starts + 1}")
        elif status == 0 and not config.again(failed, 0) and running.state != "starting":
            running.why = f"{running.member.name}: ended"
            self._set_state(running, "ended", "with status 0")
        else:
            times = f" after {running.starts} starts" if running.starts > 1 else ""
            running.why = f"{process.describe_end()}{times}"
            self._set_state(running, "failed", running.why)

    def _set_state(self, running: _Running, state: State, detail: str) -> None:
        running.state = state
        self._on_change(running.member.name, state, detail)


LOOKING = 2.0
"""How long one look at the graph may take [s]."""


class GraphWatch:
    """Whether services and topics of one DDS domain are there; connected only when somebody asks.

    Args:
        domain_id: the domain; ROS_DOMAIN_ID, else 0, by default.
    """

    def __init__(self, domain_id: int | None = None):
        self._domain = domain_id
        self._connection: Connection | None = None

    def sees(self, ready: Ready) -> bool:
        """Tell whether a service or topic has somebody who serves it."""
        from .client.connection import Connection  # a launch without readiness signs loads no ROS

        if self._connection is None:
            self._connection = Connection("grip_launch", self._domain)
        node, wanted = self._connection.node, {ready.service, f"{ready.service}/_action/send_goal"}

        def there() -> bool:
            if ready.topic:
                return bool(node.count_publishers(ready.topic))
            return any(name in wanted for name, _ in node.get_service_names_and_types())

        asked = self._connection.post(there)
        return asked.wait(LOOKING) and asked.result()

    def instead(self, ready: Ready) -> str:
        """Return which services or topics there are instead of one that didn't come, as the end of a sentence."""
        if ready.log is not None or self._connection is None:
            return ""
        from .client.graph import instead

        node, name = self._connection.node, str(ready.service or ready.topic)
        asked = self._connection.post(lambda: instead(node, name, "", "served" if ready.service else "published"))
        return asked.result() if asked.wait(LOOKING) else ""

    def close(self) -> None:
        if self._connection is not None:
            self._connection.close()
