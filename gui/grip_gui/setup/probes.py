"""Trying what is configured: verbs of `grip` in a process of their own, one at a time, with an end."""

from __future__ import annotations

import asyncio
import json
import os
import time
from collections.abc import Sequence
from pathlib import Path
from secrets import token_hex
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.interpreter import python_command
from grip_gui.processes import MARK, end_marked
from grip_gui.project import ProjectFolder
from grip_gui.setup_messages import ProbeView, ProbeWish

from .kinds import kind_of

PATIENCE = 120.0
"""How long a try may take; building interfaces the first time takes most of it [s]."""
KEPT = 20_000
"""How much of what it says is shown, the end of it [characters]."""


class Prober:
    """Runs one try at a time.

    Args:
        folder: the project.
    """

    def __init__(self, folder: ProjectFolder):
        self._folder = folder
        self._busy = asyncio.Lock()

    async def probe(self, wish: ProbeWish) -> ProbeView:
        """Try it.

        Raises:
            GripError: another try is under way, or this can't be tried.
        """
        kind = kind_of(wish.path).name
        home = self._folder.settings_file(wish.path).parent
        needed = "component" if wish.what in ("generate", "test") else "project"
        if kind != needed:
            raise GripError(f"{wish.path}: {wish.what!r} is tried with a file of the kind {needed!r}")
        words = {
            "robot": ("robot", "check", "."),
            "generate": ("component", "add", str(home)),
            "test": ("component", "test", str(home)),
        }
        return await self.run(words[wish.what])

    async def run(self, words: Sequence[str]) -> ProbeView:
        """Run `grip WORDS...` in the project folder; afterwards no process of it is left."""
        started = time.monotonic()
        ok, output = await self.ended("grip_bt.cli", words)
        shown = output if len(output) <= KEPT else "... " + output[-KEPT:]
        return ProbeView(ok=ok, command="grip " + " ".join(words), output=shown, seconds=time.monotonic() - started)

    async def answer(self, module: str, words: Sequence[str] = (), given: str = "") -> dict[str, Any]:
        """Run a module in the project folder and return its last line, an object in JSON.

        Raises:
            GripError: another try is under way, or it ended without an answer.
        """
        _, output = await self.ended(module, words, given)
        for line in reversed(output.splitlines()):
            if line.startswith("{"):
                return dict(json.loads(line))
        raise GripError(f"it gave no answer: {output[-KEPT:].strip() or 'it said nothing'}")

    async def ended(self, module: str, words: Sequence[str], given: str = "") -> tuple[bool, str]:
        """Run a module to its end; return whether it went well, and what it said.

        Raises:
            GripError: another try is under way.
        """
        if self._busy.locked():
            raise GripError("another try is under way; wait for its end")
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
        said, _ = await asyncio.wait_for(process.communicate(given.encode()), PATIENCE)
        output, ok = said.decode(errors="replace"), process.returncode == 0
    except TimeoutError:
        output, ok = f"It hasn't ended within {PATIENCE:g} s, so it was ended.", False
    finally:
        await end_marked(mark, group=process.pid if process.returncode is None else None)
        await process.wait()
    return ok, output
