"""`python -m grip_bt.app.runs.process`: the process in which runs execute, under `grip_bt.app.runs.supervisor`.

Whoever wants several runs, one after the other, says `more` in each order: planner, simulator and servers of components
stay, and `idle` tells when the run before is over. What a run has of its own is made anew: the world, commanders, the
compiled task, modules of the project's folder.
"""

from __future__ import annotations

import faulthandler
import gc
import json
import os
import signal
import sys
import threading
import traceback
from collections.abc import Mapping
from contextlib import nullcontext
from typing import TYPE_CHECKING

from grip_bt.base.errors import GripError

if TYPE_CHECKING:
    from grip_bt.app.wiring.equipment import Equipment
    from grip_bt.base.types import JsonObject
    from grip_bt.runtime.control import Control

EARLY = 130
"""Exit status after a stop that came before the run."""


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
    line = commands.readline()
    if not line:
        return 1  # who would have told us what to run has gone
    order: JsonObject | None = json.loads(line)
    from grip_bt.app.wiring.equipment import Equipment  # after the signals: importing takes a moment
    from grip_bt.runtime.control import Control

    main_thread, status, frozen = threading.get_ident(), 1, False
    with Equipment(lasting=True) as equipment:
        while order is not None:
            control = Control(commands, events, lambda: signal.pthread_kill(main_thread, signal.SIGUSR1))
            status = _execute(order, channels, control, equipment)
            if status == EARLY or not order.get("more"):
                break
            control.leave()
            control.send("idle")  # first: the parent reads what came of the run while this process tidies up
            _forget_modules(order["task"])
            gc.collect()
            if not frozen:  # to have what is frozen counted takes as long as to look through it
                gc.freeze()  # what is there after the first run stays, and needn't be looked through again
                frozen = True
            order = control.order.get()
    return status


def _forget_modules(task: str) -> None:
    """Have the next run import what belongs to the project anew: what modules keep is no business of another run's."""
    from grip_bt.app.project.folder import find_project

    folder = f"{find_project(task).folder}{os.sep}"
    for name, module in list(sys.modules.items()):
        if (getattr(module, "__file__", None) or "").startswith(folder):
            del sys.modules[name]


def _execute(order: Mapping[str, object], channels: dict[str, int], control: Control, equipment: Equipment) -> int:
    parent = os.getppid()
    try:
        signal.signal(signal.SIGUSR1, _interrupted)  # in here: a stop may be the very next command
        control.start()
        # Whoever ends what a parent has left behind doesn't stop the run; that the parent has gone is why it ends.
        signal.signal(signal.SIGTERM, lambda *_: control.stop(lost=os.getppid() != parent))
        return _run_or_say_why(order, channels, control, equipment)
    except _StoppedEarlyError:
        status = "died" if control.lost else "stopped"
        control.send("ended", status=status, outcome=None, code=None, message="before the task began", zombies=[])
        return EARLY


def _run_or_say_why(
    order: Mapping[str, object], channels: dict[str, int], control: Control, equipment: Equipment
) -> int:
    try:
        return _run(order, channels, control, equipment)
    except _StoppedEarlyError:
        raise
    except BaseException as error:  # noqa: BLE001 - the parent has to know that it isn't a node's fault
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)  # a stop comes too late now, and mustn't cut the message short
        told = str(error) if getattr(error, "issues", None) else f"grip: {error}"
        control.send("failed", message=told if isinstance(error, GripError) else traceback.format_exc())
        return 1


def _interrupted(*_: object) -> None:
    raise _StoppedEarlyError


def _run(order: JsonObject, channels: dict[str, int], control: Control, equipment: Equipment) -> int:
    from grip_bt.compilers.binding import parts_of
    from grip_bt.runtime.observers import Heartbeat

    from .execute import OPTIONS, open_session
    from .motion_record import recorded_motion
    from .verdict import Verdict

    options = OPTIONS.validate_python(order["options"])

    def progress(part: str, detail: str) -> None:
        control.send("progress", part=part, detail=detail)

    with open_session(order["task"], options, progress, channels.get("hold"), equipment) as session:
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
        moved = recorded_motion(session.resources, runner.context.clock, session.journal, runner.run_id)
        with moved if options.motion else nullcontext():
            control.run(verdict.facts)
        pulse.stop()
    return 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)  # what hangs in a thread keeps the process no longer than its journal needed
