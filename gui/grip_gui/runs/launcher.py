"""Starts the process in which a run executes, so that a crash or a hang of user code never takes the editor down."""

from __future__ import annotations

import asyncio
import json
import os
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from pathlib import Path
from secrets import token_hex
from typing import Any, TypeAlias

from grip_bt.base.interpreter import python_command
from grip_gui.processes import MARK, end_marked
from grip_gui.wire.runs import RunOptions

LINES_KEPT = 40
"""How many of the last lines of output are kept, to say why a process died."""
LONGEST_LINE = 1 << 20
POLL = 0.02
"""How often it is looked whether a process has ended [s]."""


class RunProcess:
    """A `grip run --control` under way."""

    def __init__(self, process: asyncio.subprocess.Process, mark: str):
        self._process, self._mark = process, mark
        self._tail: deque[str] = deque(maxlen=LINES_KEPT)

    async def lines(self) -> AsyncIterator[dict[str, Any]]:
        """Yield protocol objects from stdout and `{"event": "log"}` for plain text, as they come, until both end."""
        queue: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue()

        async def read(stream: asyncio.StreamReader | None) -> None:
            assert stream is not None
            try:
                while line := await _line(stream):
                    await queue.put(self._parsed(line.decode(errors="replace").rstrip()))
            finally:
                await queue.put(None)

        readers = [asyncio.create_task(read(stream)) for stream in (self._process.stdout, self._process.stderr)]
        try:
            for _ in readers:
                while (message := await queue.get()) is not None:
                    yield message
        finally:
            for reader in readers:
                reader.cancel()

    def _parsed(self, text: str) -> dict[str, Any]:
        if text.startswith("{"):
            try:
                message = json.loads(text)
            except ValueError:
                message = None
            if isinstance(message, dict) and isinstance(message.get("event"), str):
                return message
        self._tail.append(text)
        return {"event": "log", "text": text}

    async def send(self, command: Mapping[str, Any]) -> None:
        """Send a command of the control protocol; nothing happens when the process is gone."""
        stdin = self._process.stdin
        if stdin is None or stdin.is_closing():
            return
        try:
            stdin.write(json.dumps(dict(command)).encode() + b"\n")
            await stdin.drain()
        except (BrokenPipeError, ConnectionResetError):
            return

    async def wait(self) -> int:
        """Wait for the end, end what it left behind, return the exit status; negative is the signal that ended it."""
        # Not `Process.wait`: in Python 3.11 that waits for what holds the pipes too, which may be what was left behind.
        while self._process.returncode is None:
            await asyncio.sleep(POLL)
        await end_marked(self._mark)
        return self._process.returncode

    async def kill(self) -> None:
        """End the process and everything that it started, now. Idempotent."""
        await end_marked(self._mark, group=self._process.pid if self._process.returncode is None else None)
        while self._process.returncode is None:
            await asyncio.sleep(POLL)

    def tail(self) -> str:
        """Return the last lines that weren't part of the protocol."""
        return "\n".join(self._tail)


async def _line(stream: asyncio.StreamReader) -> bytes:
    """Return the next line; of one that is longer than the limit, nothing but a note."""
    try:
        return await stream.readline()
    except ValueError:
        return b"(a line that was too long was left out)\n"


async def start_run(task_file: Path, journal: Path, options: RunOptions) -> RunProcess:
    """Start `grip run --control` in a process group of its own; what it starts in turn carries a mark to be found by.

    Raises:
        OSError: the process can't be started.
    """
    journal.parent.mkdir(parents=True, exist_ok=True)
    mark = token_hex(8)
    process = await asyncio.create_subprocess_exec(
        *python_command("-m", "grip_bt.cli", "run", str(task_file), "--control", "--journal", str(journal)),
        *options.arguments(),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        limit=LONGEST_LINE,
        env={**os.environ, MARK: mark, "PYTHONUNBUFFERED": "1"},
        start_new_session=True,
    )
    return RunProcess(process, mark)


Launch: TypeAlias = Callable[[Path, Path, RunOptions], Awaitable[RunProcess]]
"""Starts a run of a task's file, which writes to a journal."""
