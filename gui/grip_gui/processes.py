"""Processes that the editor starts: what they say, and the end of everything that they started."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from secrets import token_hex
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.interpreter import python_command
from grip_gui.wire.setup import CommandResult

MARK = "GRIP_RUN_MARK"  # environment variable that a process shares with all that it starts
GRACE = 1.0  # how long a left-over process may take to end after SIGTERM [s]
POLL = 0.02  # how often it is looked whether a process has ended [s]
LONGEST_LINE = 1 << 26


def marked(mark: str) -> list[int]:
    """Return the ids of all living processes of this user that carry the mark; never this one."""
    needle = f"{MARK}={mark}".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            with suppress(OSError):  # it has ended, or belongs to somebody else
                if needle in (entry / "environ").read_bytes().split(b"\0"):
                    found.append(int(entry.name))
    return found


async def end_marked(mark: str, group: int | None = None) -> None:
    """End all processes with the mark: those in the process group `group` at once, others with a chance to clean up."""
    if group is not None:
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
    _signal(marked(mark), signal.SIGTERM)
    loop = asyncio.get_running_loop()
    deadline = loop.time() + GRACE
    while (left := marked(mark)) and loop.time() < deadline:
        await asyncio.sleep(POLL)
    _signal(left, signal.SIGKILL)


def _signal(pids: list[int], number: signal.Signals) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, number)


async def spawned(words: Sequence[str], stderr: int, folder: Path) -> tuple[asyncio.subprocess.Process, str]:
    """Start a module of this Python in a process group of its own; return it, and the mark of all that it starts."""
    mark = token_hex(8)
    process = await asyncio.create_subprocess_exec(
        *python_command("-m", *words),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=stderr,
        cwd=folder,
        limit=LONGEST_LINE,
        env={**os.environ, MARK: mark, "PYTHONUNBUFFERED": "1"},
        start_new_session=True,
    )
    return process, mark


PATIENCE = 120.0  # how long a try may take; building interfaces the first time takes most of it [s]
KEPT = 20_000  # how much of what it says is shown, the end of it [characters]


class CommandRunner:
    """Runs one try at a time in the project's folder; afterwards no process of it is left."""

    def __init__(self, folder: Path):
        self._folder = folder
        self._busy = asyncio.Lock()

    async def run(self, words: Sequence[str]) -> CommandResult:
        """Run `grip WORDS...`."""
        started = time.monotonic()
        ok, output = await self._ended("grip_bt.cli", words)
        shown = output if len(output) <= KEPT else "... " + output[-KEPT:]
        return CommandResult(ok=ok, command="grip " + " ".join(words), output=shown, seconds=time.monotonic() - started)

    async def answer(self, module: str, **question: object) -> dict[str, Any]:
        """Run a module that answers by `answer_question`; return its answer. Raises GripError where it is an error."""
        _, output = await self._ended(module, (), json.dumps(question))
        for line in reversed(output.splitlines()):
            if line.startswith("{"):
                if "error" in (found := json.loads(line)) and found["error"]:
                    raise GripError(found["error"])
                return dict(found)
        raise GripError(f"no answer: {output[-KEPT:].strip() or 'no output'}")

    async def _ended(self, module: str, words: Sequence[str], given: str = "") -> tuple[bool, str]:
        """Run a module to its end; return whether it went well, and what it said."""
        if self._busy.locked():
            raise GripError("another command is running; wait for it to end")
        async with self._busy:
            process, mark = await spawned((module, *words), asyncio.subprocess.STDOUT, self._folder)
            try:
                async with asyncio.timeout(PATIENCE):
                    said, _ = await process.communicate(given.encode())
                return process.returncode == 0, said.decode(errors="replace")
            except TimeoutError:
                return False, f"Killed: it did not end within {PATIENCE:g} s."
            finally:
                await end_marked(mark, group=process.pid if process.returncode is None else None)
                await process.wait()


def answer_question(answer: Callable[..., Mapping[str, Any]]) -> int:
    """In a child process: read keyword arguments as JSON from the standard input, print what `answer` returns of them.

    The answer is the last line, an object in JSON; `error` in it says why there is none.
    """
    try:
        found = answer(**json.loads(sys.stdin.read()))
    except (ExpectedError, GripError, ValueError, OSError) as error:
        found = {"error": reason_of(error)}
    sys.stdout.write("\n" + json.dumps(found) + "\n")
    return 0


def reason_of(error: Exception) -> str:
    """Return why something didn't work."""
    return error.message if isinstance(error, ExpectedError) else str(error)
