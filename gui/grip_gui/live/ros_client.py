"""A process that looks at ROS for the editor: native code that breaks there takes no page down.

Requests and answers are JSON, one a line. It is started at the first question, and ends when nobody has asked for a
while, when the editor closes, and when the editor dies (its standard input ends).
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
import os
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.interpreter import python_command

IDLE = 60.0
"""How long it stays without a question [s]; a connection to ROS takes a second to come up, and costs a little CPU."""
PATIENCE = 60.0
"""Longest time to an answer [s]."""
LONGEST_LINE = 1 << 26
CLOSING = 5.0


class RosClientError(GripError):
    """The process that looks at ROS can't, or says why something can't be done."""


class RosClientProcess:
    """Asks the process; all methods belong to the event loop.

    Args:
        project: the project's folder, in which the process works.
        idle: how long the process stays without a question [s].
    """

    def __init__(self, project: Path, idle: float = IDLE):
        self._project, self._idle = project, idle
        self._process: asyncio.subprocess.Process | None = None
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._numbers = itertools.count(1)
        self._starting = asyncio.Lock()
        self._ending: asyncio.TimerHandle | None = None
        self._listening: set[asyncio.Task[None]] = set()
        self._kept = False

    async def ask(self, do: str, **fields: object) -> dict[str, Any]:
        """Return the answer to a question.

        Raises:
            RosClientError: it can't be answered; the message says why.
        """
        async with self._starting:
            process = self._process or await self._start()
        number, answer = next(self._numbers), asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        assert process.stdin is not None
        try:
            process.stdin.write(json.dumps({"id": number, "do": do, **fields}).encode() + b"\n")
            await process.stdin.drain()
            async with asyncio.timeout(PATIENCE):
                found = await answer
        except TimeoutError:
            raise RosClientError(f"no answer within {PATIENCE:g} s") from None
        except OSError as error:
            raise RosClientError(f"the ROS process is gone: {error}") from None
        finally:
            self._waiting.pop(number, None)
            self._stay()
        if "error" in found:
            raise RosClientError(found["error"])
        return dict(found["value"])

    def keep(self, kept: bool) -> None:
        """Have the process stay also when nobody asks, because it serves something."""
        self._kept = kept
        self._stay()

    async def close(self) -> None:
        """End the process; afterwards none is left, nor one that was ending for want of questions."""
        if self._ending is not None:
            self._ending.cancel()
        self._end()
        # In Python 3.11 a process is waited for until its pipes are closed too, and somebody else may hold them.
        if self._listening:
            await asyncio.wait(self._listening, timeout=2 * CLOSING)

    async def _start(self) -> asyncio.subprocess.Process:
        process = self._process = await asyncio.create_subprocess_exec(
            *python_command("-m", "grip_gui.live.ros_worker"),
            cwd=self._project,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            limit=LONGEST_LINE,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            start_new_session=True,
        )
        task = asyncio.create_task(self._listen(process))
        self._listening.add(task)
        task.add_done_callback(self._listening.discard)
        return process

    async def _listen(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        assert process.stderr is not None
        last = asyncio.create_task(_tail(process.stderr))
        with contextlib.suppress(ValueError):  # a line beyond the limit: what reads it can't be trusted further
            while line := await process.stdout.readline():
                found = json.loads(line)
                waiting = self._waiting.get(found.get("id"))
                if waiting is not None and not waiting.done():
                    waiting.set_result(found)
        _kill(process)
        status, said = await process.wait(), await last
        if self._process is process:
            self._process = None
        elif self._process is not None:
            return  # another one answers what is waited for now
        reason = f"the ROS process has ended ({status}){': ' + said if said else ''}"
        for waiting in list(self._waiting.values()):
            if not waiting.done():
                waiting.set_result({"error": reason})

    def _stay(self) -> None:
        if self._ending is not None:
            self._ending.cancel()
        self._ending = asyncio.get_running_loop().call_later(self._idle, self._end_unless_kept)

    def _end_unless_kept(self) -> None:
        if not self._kept and not self._waiting:
            self._end()

    def _end(self) -> None:
        """Let the process end, which is waited for where it is listened to; one that doesn't is killed."""
        process, self._process = self._process, None
        if process is not None and process.stdin is not None:
            process.stdin.close()
            asyncio.get_running_loop().call_later(CLOSING, _kill, process)


def _kill(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            process.kill()


async def _tail(stream: asyncio.StreamReader) -> str:
    """Read a stream to its end; return the last line."""
    last = b""
    with contextlib.suppress(ValueError):
        while line := await stream.readline():
            last = line.strip() or last
    return last.decode(errors="replace")
