"""Processes that the editor starts: commands tried one at a time, and the end of everything that they started."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
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
        _signal_group(group, signal.SIGKILL)
    _signal_all(marked(mark), signal.SIGTERM)
    loop = asyncio.get_running_loop()
    deadline = loop.time() + GRACE
    while (left := marked(mark)) and loop.time() < deadline:
        await asyncio.sleep(0.02)
    _signal_all(left, signal.SIGKILL)


def _signal_all(pids: list[int], number: signal.Signals) -> None:
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            continue


def _signal_group(group: int, number: signal.Signals) -> None:
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        return


PATIENCE = 120.0
"""How long a try may take; building interfaces the first time takes most of it [s]."""
KEPT = 20_000
"""How much of what it says is shown, the end of it [characters]."""


class CommandRunner:
    """Runs one try at a time.

    Args:
        folder: the project.
    """

    def __init__(self, folder: ProjectFolder):
        self._folder = folder
        self._busy = asyncio.Lock()

    async def run(self, words: Sequence[str]) -> CommandResult:
        """Run `grip WORDS...` in the project folder; afterwards no process of it is left."""
        started = time.monotonic()
        ok, output = await self.ended("grip_bt.cli", words)
        shown = output if len(output) <= KEPT else "... " + output[-KEPT:]
        return CommandResult(ok=ok, command="grip " + " ".join(words), output=shown, seconds=time.monotonic() - started)

    async def answer(self, module: str, **question: object) -> dict[str, Any]:
        """Run a module that answers by `answer_question` in the project folder; return its answer.

        Raises:
            GripError: another try is under way, or it ended without an answer.
        """
        _, output = await self.ended(module, (), json.dumps(question))
        for line in reversed(output.splitlines()):
            if line.startswith("{"):
                return dict(json.loads(line))
        raise GripError(f"no answer: {output[-KEPT:].strip() or 'no output'}")

    async def ended(self, module: str, words: Sequence[str], given: str = "") -> tuple[bool, str]:
        """Run a module to its end; return whether it went well, and what it said.

        Raises:
            GripError: another try is under way.
        """
        if self._busy.locked():
            raise GripError("another command is running; wait for it to end")
        async with self._busy:
            return await _ended(python_command("-m", module, *words), self._folder.folder, given)


async def _ended(command: Sequence[str], folder: Path, given: str) -> tuple[bool, str]:
    mark = token_hex(8)
    process = await asyncio.create_subprocess_exec(
        *command,
        cwd=folder,
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        env={**os.environ, MARK: mark, "PYTHONUNBUFFERED": "1"},
        start_new_session=True,
    )
    try:
        async with asyncio.timeout(PATIENCE):
            said, _ = await process.communicate(given.encode())
        output, ok = said.decode(errors="replace"), process.returncode == 0
    except TimeoutError:
        output, ok = f"Killed: it did not end within {PATIENCE:g} s.", False
    finally:
        await end_marked(mark, group=process.pid if process.returncode is None else None)
        await process.wait()
    return ok, output


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
