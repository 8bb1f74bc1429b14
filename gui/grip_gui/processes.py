"""Processes that the editor starts: commands tried one at a time, and the end of everything that they started."""

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
from grip_gui.project import ProjectFolder
from grip_gui.wire.setup import CommandResult

MARK = "GRIP_RUN_MARK"
"""Environment variable that all processes of one run share."""
GRACE = 1.0
"""How long a left-over process may take to end after SIGTERM [s]."""


def marked(mark: str) -> list[int]:
    """Return the ids of all living processes of this user that carry the mark; never this one."""
    needle = f"{MARK}={mark}".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit() or int(entry.name) == os.getpid():
            continue
        try:
            environment = (entry / "environ").read_bytes()
        except OSError:
            continue  # it has ended, or belongs to somebody else
        if needle in environment.split(b"\0"):
            found.append(int(entry.name))
    return found


async def end_marked(mark: str, group: int | None = None) -> None:
    """End all processes with the mark: those in `group` at once, the others with a chance to clean up.

    Args:
        mark: value of the environment variable `MARK`.
        group: a process group to kill first, None for none.
    """
    if group is not None:
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
    _signal(marked(mark), signal.SIGTERM)
    loop = asyncio.get_running_loop()
    deadline = loop.time() + GRACE
    while (left := marked(mark)) and loop.time() < deadline:
        await asyncio.sleep(0.02)
    _signal(left, signal.SIGKILL)


def _signal(pids: list[int], number: signal.Signals) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, number)


PATIENCE = 120.0
"""How long a try may take; building interfaces the first time takes most of it [s]."""
KEPT = 20_000
"""How much of what it says is shown, the end of it [characters]."""


class CommandRunner:
    """Runs one try at a time."""

    def __init__(self, folder: ProjectFolder):
        self._folder = folder
        self._busy = asyncio.Lock()

    async def run(self, words: Sequence[str]) -> CommandResult:
        """Run `grip WORDS...` in the project folder; afterwards no process of it is left."""
        started = time.monotonic()
        ok, output = await self._ended("grip_bt.cli", words)
        shown = output if len(output) <= KEPT else "... " + output[-KEPT:]
        return CommandResult(ok=ok, command="grip " + " ".join(words), output=shown, seconds=time.monotonic() - started)

    async def answer(self, module: str, **question: object) -> dict[str, Any]:
        """Run a module that answers by `answer_question` in the project folder; return its answer.

        Raises:
            GripError: another try is under way, or it ended without an answer.
        """
        _, output = await self._ended(module, (), json.dumps(question))
        for line in reversed(output.splitlines()):
            if line.startswith("{"):
                return dict(json.loads(line))
        raise GripError(f"no answer: {output[-KEPT:].strip() or 'no output'}")

    async def _ended(self, module: str, words: Sequence[str], given: str = "") -> tuple[bool, str]:
        """Run a module to its end; return whether it went well, and what it said."""
        if self._busy.locked():
            raise GripError("another command is running; wait for it to end")
        async with self._busy:
            mark = token_hex(8)
            process = await asyncio.create_subprocess_exec(
                *python_command("-m", module, *words),
                cwd=self._folder.folder,
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.STDOUT,
                env={**os.environ, MARK: mark, "PYTHONUNBUFFERED": "1"},
                start_new_session=True,
            )
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
    except ExpectedError as error:
        found = {"error": error.message}
    except (GripError, ValueError, OSError) as error:
        found = {"error": str(error)}
    sys.stdout.write("\n" + json.dumps(found) + "\n")
    return 0
