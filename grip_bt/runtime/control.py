"""Control of a run over two streams: one JSON object a line, commands in, events out; the end of input is a stop."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from typing import Any, TextIO

from .runner import Runner, RunResult


class _Out:
    """Writes lines from any thread, and from a signal handler; a reader that has gone away is a reason to stop."""

    def __init__(self, stream: TextIO, gone: Callable[[], None]):
        self._stream, self._gone, self._lock = stream, gone, threading.RLock()

    def send(self, event: str, **fields: Any) -> None:
        """Write one event."""
        try:
            with self._lock:
                self._stream.write(json.dumps({"event": event, **fields}) + "\n")
                self._stream.flush()
        except (OSError, ValueError, RuntimeError):
            self._gone()


def serve_control(runner: Runner, commands: TextIO, events: TextIO) -> RunResult:
    """Run to the end in this thread, obeying `{"command": "pause" | "resume" | "step" | "stop"}` meanwhile.

    Events: `started`, `committed` (the journal's events up to `seq` can be read), `state`, `refused` (a line that isn't
    a command), `ended`.

    Args:
        runner: not run yet.
        commands: what to obey, such as `sys.stdin`.
        events: where to tell, such as `sys.stdout`.
    """
    out = _Out(events, runner.stop)
    journal = runner.journal
    if journal is not None:
        journal.on_commit(lambda run, seq: out.send("committed", seq=seq) if run == runner.run_id else None)
    runner.pacing.on_state(lambda state: out.send("state", state=state))
    out.send("started", run=runner.run_id, journal=str(journal.file) if journal is not None else None)
    threading.Thread(target=_obey, args=(runner, commands, out), name="grip_control", daemon=True).start()
    result = runner.run()
    if journal is not None:
        journal.flush()
    out.send("ended", status=result.status, outcome=result.outcome)
    return result


def _obey(runner: Runner, commands: TextIO, out: _Out) -> None:
    allowed: dict[str, Callable[[], None]] = {
        "pause": runner.pause,
        "resume": runner.resume,
        "step": runner.step,
        "stop": runner.stop,
    }
    for line in _lines(commands):
        try:
            command = json.loads(line)["command"]
            allowed[command]()
        except (ValueError, KeyError, TypeError):
            out.send("refused", message=f"not a command: {line.strip()[:80]!r} (there are: {', '.join(allowed)})")
    runner.stop()


def _lines(stream: TextIO) -> Iterator[str]:
    """Yield lines that aren't blank until the stream ends, breaks or is closed."""
    try:
        yield from (line for line in stream if line.strip())
    except (OSError, ValueError):
        return
