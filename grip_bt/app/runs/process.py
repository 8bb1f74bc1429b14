"""`python -m grip_bt.app.runs.process`: the process in which a run executes, under `grip_bt.app.runs.supervisor`."""

from __future__ import annotations

import faulthandler
import json
import os
import signal
import sys
import threading
import traceback
from typing import TYPE_CHECKING, Any

from grip_bt.base.errors import GripError

if TYPE_CHECKING:
    from grip_bt.runtime.control import Control


class _StoppedEarlyError(BaseException):
    """A stop has come while the run was being started."""


def main() -> int:
    """Run what the first line of commands says; the parent tells of it."""
    channels = json.loads(sys.argv[1])
    # Ctrl-C, and the end of a terminal, reach the whole process group; what to do about it is the parent's decision.
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    os.environ["GRIP_WATCHDOG_REPORT"] = str(channels["report"])  # as `grip_bt.ros.watchdog` has it
    faulthandler.enable(os.fdopen(channels["trace"], "w"))
    commands, events = os.fdopen(channels["commands"]), os.fdopen(channels["events"], "w")
    parent, line = os.getppid(), commands.readline()
    if not line:
        return 1  # who would have told us what to run has gone
    order = json.loads(line)
    from grip_bt.runtime.control import Control  # after the signals: importing takes a moment

    main_thread = threading.get_ident()
    control = Control(commands, events, lambda: signal.pthread_kill(main_thread, signal.SIGUSR1))
    try:
        signal.signal(signal.SIGUSR1, _interrupted)  # in here: a stop may be the very next command
        control.start()
        # Whoever ends what a parent has left behind doesn't stop the run; that the parent has gone is why it ends.
        signal.signal(signal.SIGTERM, lambda *_: control.stop(lost=os.getppid() != parent))
        return _run_or_say_why(order, channels, control)
    except _StoppedEarlyError:
        status = "died" if control.lost else "stopped"
        control.send("ended", status=status, outcome=None, code=None, message="before the task began", zombies=[])
        return 130


def _run_or_say_why(order: dict[str, Any], channels: dict[str, int], control: Control) -> int:
    try:
        return _run(order, channels, control)
    except _StoppedEarlyError:
        raise
    except BaseException as error:  # noqa: BLE001 - the parent has to know that it isn't a node's fault
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # a stop comes too late now, and mustn't cut the message short
        told = str(error) if getattr(error, "issues", None) else f"grip: {error}"
        control.send("failed", message=told if isinstance(error, GripError) else traceback.format_exc())
        return 1


def _interrupted(*_: object) -> None:
    raise _StoppedEarlyError


def _run(order: dict[str, Any], channels: dict[str, int], control: Control) -> int:
    from grip_bt.compilers.binding import parts_of
    from grip_bt.runtime.observers import Heartbeat

    from .execute import OPTIONS, open_session
    from .motion_record import recorded_motion
    from .verdict import Verdict

    options = OPTIONS.validate_python(order["options"])

    def progress(part: str, detail: str) -> None:
        control.send("progress", part=part, detail=detail)

    with open_session(order["task"], options, progress, hold=channels.get("hold")) as session:
        try:
            verdict = Verdict(session)
            paths = list(parts_of(session.runner.compiled))
            pulse = Heartbeat(channels["pulse"], paths)
            session.runner.observe(pulse)
            control.send("nodes", paths=paths)
            control.attach(session.runner)
            signal.signal(signal.SIGUSR1, signal.SIG_IGN)
        except _StoppedEarlyError:
            control.end(session.runner)  # the run is in the journal: how it has ended is entered there
            raise
        pulse.start()
        runner = session.runner
        assert runner.run_id is not None, "a session's runs are in its journal"
        with recorded_motion(session.resources, runner.context.clock, session.journal, runner.run_id):
            control.run(verdict.facts)
        pulse.stop()
    return 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)  # what hangs in a thread keeps the process no longer than its journal needed
