"""A run in a process of its own, and its certain end.

The parent passes commands on and events back. It knows, through shared memory, which node its run was in last; when
the process dies, or stands still, it says so in the journal. When the process doesn't acknowledge a stop in time, the
parent holds the robot over a channel of its own and ends the process.
"""

from __future__ import annotations

import json
import os
import re
import select
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path

from grip_bt.app.runs.execute import OPTIONS, RunOptions
from grip_bt.base.errors import GripError
from grip_bt.base.files import Closing
from grip_bt.base.interpreter import how_ended, python_command
from grip_bt.base.types import JsonObject
from grip_bt.runtime import Journal, RunLog
from grip_bt.runtime.control import RunEnd
from grip_bt.runtime.motion_end import Rest
from grip_bt.runtime.observers import LARGEST, HeartbeatReader

ACKNOWLEDGE = 0.05
"""How long [s] the run's process may take to acknowledge a stop."""
WIND_DOWN = 15.0
"""How long [s] it may take after that to have the robot measured at rest, and to close its parts."""
STILL = 0.5
"""How long [s] after a stop it may show no sign of life before it has ended; it shows several in that time."""
REAPED = 11.0
"""How long [s] the watchdog of a robot over ROS may take to say what came of a run whose process has died."""
HOLD = 2.0
"""How long [s] a simulator is listened to before the process is ended. It answers when its joints rest, or don't come
to rest: braking takes half a second of its time at most, and 1 s later it gives up."""
LOOK = 0.25
"""How often [s] the parent looks whether the run's process is alive."""
SINGLE = {"OPENBLAS_NUM_THREADS": "1"}
"""What a run's processes multiply is so small that a second thread only waits: it cost a network's answer seven times
its CPU time. Who wants more for a component of their own sets it."""

EventListener = Callable[[JsonObject], None]


class RunProcess(Closing):
    """A child process that executes runs, one after the other, and the channels to it; `idle` between two of them.

    Args:
        terminal: whether the child has our stdin and stdout; else it reads nothing, and prints to stderr.

    Raises:
        GripError: it can't be started; it says what the system refuses.
    """

    def __init__(self, terminal: bool = True):
        with ExitStack() as stack:  # of the child's ends
            try:
                commands, self.command_end = os.pipe()
                event_end, events = os.pipe()
                self.hold_end, hold = socket.socketpair()
                report_end, report = os.pipe()
                for each in (commands, events, report):
                    stack.callback(os.close, each)
                stack.callback(hold.close)
                self.memory, self.trace = tempfile.TemporaryFile(), tempfile.TemporaryFile()
                self.memory.truncate(LARGEST)
                self.pulse = HeartbeatReader(self.memory.fileno())
                files = {"hold": hold.fileno(), "pulse": self.memory.fileno(), "trace": self.trace.fileno()}
                channels = {"commands": commands, "events": events, "report": report, **files}
                self.child = subprocess.Popen(
                    python_command("-m", "grip_bt.app.runs.process", json.dumps(channels)),
                    pass_fds=list(channels.values()),
                    stdin=None if terminal else subprocess.DEVNULL,
                    stdout=None if terminal else 2,
                    env={**SINGLE, **os.environ},
                )
            except OSError as error:
                why = f"{error.strerror}; `ulimit -a` and the room in {tempfile.gettempdir()} (TMPDIR) tell more"
                raise GripError(f"the run's process can't be started: {why}") from None
        self.events, self.report = os.fdopen(event_end), os.fdopen(report_end, "rb", 0)
        self.idle = True
        self._lock = threading.RLock()
        self._told_all = False

    @property
    def waits(self) -> bool:
        """Whether it lives, and waits for a run."""
        return self.idle and self.child.poll() is None

    def send(self, command: Mapping[str, object]) -> None:
        """Pass a command on, from any thread; one that has ended meanwhile is noticed elsewhere."""
        line = json.dumps(command, default=str).encode() + b"\n"
        with self._lock, suppress(OSError):
            if not self._told_all:
                os.write(self.command_end, line)

    def say_no_more(self) -> None:
        """Close the commands; a process that hears of it before a stop knows that it is on its own."""
        with self._lock:
            if not self._told_all:
                self._told_all = True
                os.close(self.command_end)

    def close(self) -> None:
        """Have it end; harmless when it has. One that executes a run is on its own then, see `say_no_more`."""
        self.say_no_more()
        try:
            self.child.wait(WIND_DOWN)
        except subprocess.TimeoutExpired:
            self.child.kill()
            self.child.wait()
        if self.idle:
            self.events.close()  # else by who reads them, at their end
        self.hold_end.close()
        self.report.close()
        self.memory.close()
        self.trace.close()


class Supervisor:
    """Runs one task in a child process.

    Args:
        told: called with each event of the run, in a thread of the supervisor.
        silence: how long [s] the process may stand still before it is ended; None for ever.
        terminal: whether the child has our stdin and stdout; else it reads nothing, and prints to stderr.
        process: one that is idle, and is idle again afterwards if nothing went wrong; None for one of the run's own.
    """

    def __init__(
        self,
        task: str,
        options: RunOptions,
        told: EventListener,
        silence: float | None = None,
        terminal: bool = True,
        process: RunProcess | None = None,
    ):
        self._told, self._silence = told, silence
        more = process is not None
        self._order = {"task": task, "options": OPTIONS.dump_python(options, mode="json"), "more": more}
        self._robot = options.robot
        self._terminal = terminal
        self._given = process
        self._lock = threading.RLock()
        self._acknowledged, self._over = threading.Event(), threading.Event()
        self._stopping = self._lost = False
        self._why = ""
        self._begun = time.monotonic()
        self._paths: list[str] = []
        self._run: JsonObject | None = None
        self._ended: RunEnd | None = None
        self._stood_still = self._simulated = False
        self._held: dict[str, str] = {}

    # --- for whoever controls the run ---

    def start(self) -> None:
        """Start the process. Raises GripError where it can't be; it says what the system refuses."""
        self._process = self._given or RunProcess(self._terminal)
        self._process.idle = False
        self._process.send(self._order)
        self._reader = threading.Thread(target=self._read, name="grip_events", daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        """The child's process id."""
        return self._process.child.pid

    @property
    def started(self) -> JsonObject | None:
        """The event `started`; None as long as nothing has begun."""
        return self._run

    def send(self, command: Mapping[str, object]) -> None:
        """Pass a command on; `stop` is seen to. From any thread."""
        if command.get("command") == "stop":
            self.stop()
        else:
            self._process.send(command)

    def stop(self, lost: bool = False) -> None:
        """Stop the run, or its start; whatever the process does. May be called from a signal handler.

        With `lost`, nobody has asked for that, but whoever controls the run has gone: it can be resumed.
        """
        with self._lock:
            if self._stopping:
                return
            self._stopping, self._lost = True, lost
        threading.Thread(target=self._stop, args=(time.monotonic(),), name="grip_stop", daemon=True).start()

    def wait(self) -> RunEnd:
        """Wait for the end of the process, and return the event `ended`, or `failed` when nothing could be run."""
        try:
            status = self._watch()
        finally:
            self._over.set()
        self._reader.join(2.0)
        if self._ended is None:
            self._ended = self._obituary(status)
            self._told(self._ended)
        if not self._process.idle:
            self._process.close()
        return self._ended

    # --- its threads ---

    def _stop(self, called: float) -> None:
        if self._lost:
            self._process.say_no_more()
        else:
            self._process.send({"command": "stop"})
        if not self._acknowledged.wait(called + ACKNOWLEDGE - time.monotonic()):
            self._told({"event": "state", "state": "stopping"})
            self._hold()
            self._kill(f"did not acknowledge the stop within {1000 * ACKNOWLEDGE:.0f} ms")
            return
        while time.monotonic() < called + WIND_DOWN:
            count = self._process.pulse.count
            if self._over.wait(STILL):
                return
            if self._run is not None and self._ended is None and self._process.pulse.count == count:
                self._hold()
                self._kill("hung after it had acknowledged the stop")
                return
        self._kill(f"did not end within {WIND_DOWN:g} s of the stop")

    def _hold(self) -> None:
        """Have the simulator, where there is one, hold the robot, and take note of what it has measured then."""
        if not self._simulated:
            return
        try:
            self._process.hold_end.settimeout(HOLD)
            self._process.hold_end.sendall(b"hold")
            said = self._process.hold_end.recv(1024).decode() or "the simulator has gone"
        except OSError:
            said = f"the simulator did not confirm it within {HOLD:g} s"
        self._held = {"robot": "" if said == "held" else said}

    def _kill(self, why: str) -> None:
        self._why = why
        try:
            self._process.child.kill()
        except OSError:
            return  # it has ended meanwhile

    def _watch(self) -> int:
        count, still, looked = -1, 0.0, time.monotonic()
        while True:
            self._reader.join(LOOK)
            if self._process.idle:
                return 0
            try:
                return self._process.child.wait(0 if self._reader.is_alive() else LOOK)
            except subprocess.TimeoutExpired:
                pass
            step, looked = min(time.monotonic() - looked, 2 * LOOK), time.monotonic()  # not while we stood still
            now = self._process.pulse.count
            still = 0.0 if now != count or self._run is None or self._ended is not None else still + step
            count = now
            if self._silence is not None and still > self._silence and not self._why:
                self._stood_still = True
                self._hold()
                self._kill(f"stood still for {self._silence:g} s: its code blocks every other thread")

    def _read(self) -> None:
        for line in self._process.events:
            event = json.loads(line)
            match event["event"]:
                case "idle":
                    self._process.idle = True
                    return
                case "nodes":
                    self._paths = event["paths"]
                    continue
                case "progress" if event["part"] == "simulator":
                    self._simulated = True
                case "started":
                    self._run, self._begun = event, time.monotonic()
                case "state" if event["state"] == "stopping":
                    self._acknowledged.set()
                case "ended" | "failed":
                    self._acknowledged.set()
                    self._ended = event
            self._told(event)
        self._process.events.close()

    # --- a death ---

    def _at_rest(self) -> dict[str, str]:
        """Return what watchdogs say of what moves over ROS: part or action -> why its rest isn't known, or nothing."""
        text, deadline = b"", time.monotonic() + REAPED
        report = self._process.report
        while (left := deadline - time.monotonic()) > 0 and select.select([report], [], [], left)[0]:
            more = os.read(report.fileno(), 1 << 16)
            if not more:
                break
            text += more
        else:
            if self._robot == "ros":
                return {"robot": f"nothing confirmed within {REAPED:g} s that it is at rest"}
        return {part: why for line in text.splitlines() for part, why in json.loads(line).items()}

    def _obituary(self, status: int) -> RunEnd:
        """Return the event `ended` of a process that couldn't send it, and enter it into the journal."""
        stopped = self._stopping and not self._stood_still
        last, active = self._process.pulse.where(self._paths)
        path = last if last in active or not active else active[-1]
        how = self._why or how_ended(status) + (" before the task had ended" if status >= 0 else "")
        message = f"the run's process {how}"
        self._process.trace.seek(0)
        trace = self._process.trace.read(1 << 16).decode(errors="replace")
        if self._run is None:
            message = "before the task began" if stopped else f"{message}, and before it began"
        elif not stopped:
            others = ", ".join(p for p in active if p != path)
            said = (
                f"{path}: {message}",
                f"last node entered: {last}",
                others and f"also active: {others}",
                _place(trace),
            )
            message = "; ".join(filter(None, said))
        measured = {**self._held, **self._at_rest()}
        unconfirmed = {part: why for part, why in measured.items() if why}
        rest = str(Rest(tuple(part for part in measured if part not in unconfirmed), unconfirmed))
        end = "died" if stopped and self._lost else "stopped" if stopped else "error"
        if self._run is not None:
            self._enter(path if self._paths else "/", end, f"{message}; {rest}" if rest else message, trace)
        return {
            "event": "ended",
            "status": end,
            "outcome": None,
            "code": None,
            "message": message,
            "path": path,
            "duration": time.monotonic() - self._begun,
            "ticks": None,
            "zombies": active if stopped else [],
            "rest": rest,
            "unconfirmed": unconfirmed,
        }

    def _enter(self, path: str, status: str, message: str, trace: str) -> None:
        assert self._run is not None, "there is a run to end"
        run, file, t = self._run["run"], self._run["journal"], time.monotonic() - self._begun
        if file is None:
            return
        try:
            with Journal(Path(file)) as journal:
                log = RunLog(journal, run)
                if status == "error":
                    log.append(t, path, "error", data={"type": "ProcessDied", "message": message, "traceback": trace})
                log.append(t, "/", "run_ended", data={"status": status, "message": message})
                log.end(status, None)
        except GripError as error:
            sys.stderr.write(f"grip: {error}\n")


def _place(trace: str) -> str:
    """Return where the thread that died was, from a dump of faulthandler: innermost, outside Python's library."""
    died = re.search(r"^Current thread.*\n((?:  .*\n?)*)", trace, re.MULTILINE)
    frames = [] if died is None else [line.strip() for line in died[1].splitlines() if line.strip().startswith("File ")]
    library = f'File "{os.path.dirname(os.__file__)}/'
    ours = [f for f in frames if not f.startswith(library) or "site-packages" in f] or frames
    return f"at {ours[0]}" if ours else ""
