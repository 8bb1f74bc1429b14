"""A process that looks at ROS for the page: started when it is asked first.

`python -m grip_gui.live.ros_client` is that process. Native code that breaks in it takes no page down.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.interpreter import how_ended
from grip_gui.processes import end_marked, reason_of, spawned

PATIENCE = 60.0  # longest time to an answer [s]
CLOSING = 5.0  # how long it may take to end [s]
WORKERS = 4  # questions at a time: one that waits for a message keeps no other waiting


class RosClientError(GripError):
    """The process that looks at ROS can't, or says why something can't be done."""


class RosClientProcess:
    """Asks the process, which works in the project's folder; all methods belong to the event loop."""

    def __init__(self, project: Path):
        self._project = project
        self._process: asyncio.subprocess.Process | None = None
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._numbers = itertools.count(1)
        self._starting = asyncio.Lock()
        self._life: asyncio.Task[None] | None = None

    async def ask(self, do: str, **fields: object) -> dict[str, Any]:
        """Return the answer to a question; RosClientError says why there is none."""
        async with self._starting:
            if self._process is None:
                words, pipe = ["grip_gui.live.ros_client"], asyncio.subprocess.PIPE
                self._process, self._mark = await spawned(words, pipe, self._project)
                self._life = asyncio.create_task(self._live(self._process))
            stdin = self._process.stdin
        number, answer = next(self._numbers), asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        assert stdin is not None
        try:
            stdin.write(json.dumps({"id": number, "do": do, **fields}).encode() + b"\n")
            async with asyncio.timeout(PATIENCE):
                found = await answer
        except TimeoutError:
            raise RosClientError(f"no answer within {PATIENCE:g} s") from None
        finally:
            del self._waiting[number]
        if "error" in found:
            raise RosClientError(found["error"])
        return dict(found["value"])

    async def close(self) -> None:
        """End the process, at the end of its input or by force; afterwards none is left."""
        if self._process is None or self._life is None or self._process.stdin is None:
            return
        self._process.stdin.close()
        try:
            async with asyncio.timeout(CLOSING):
                await asyncio.shield(self._life)
        except TimeoutError:
            await end_marked(self._mark, group=self._process.pid)
            await self._life

    async def _live(self, process: asyncio.subprocess.Process) -> None:
        said = ""

        async def answers() -> None:
            assert process.stdout is not None
            async for line in process.stdout:
                found = json.loads(line)
                waiting = self._waiting.get(found["id"])
                if waiting is not None and not waiting.done():
                    waiting.set_result(found)

        async def log() -> None:
            nonlocal said
            assert process.stderr is not None
            async for line in process.stderr:
                said = line.decode(errors="replace").strip() or said

        await asyncio.gather(answers(), log())
        status = await process.wait()
        await end_marked(self._mark)
        self._process = None
        for waiting in self._waiting.values():
            if not waiting.done():
                waiting.set_result({"error": f"the ROS process {how_ended(status)}{said and ': ' + said}"})


def main() -> int:
    """Answer questions, from the standard input until it ends, on the standard output."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints isn't an answer
    speaking, opening = threading.Lock(), threading.Lock()
    looker: list[Any] = []

    def found(do: str, fields: dict[str, Any]) -> dict[str, Any]:
        try:
            from grip_bt.ros.environment import require

            require()  # before anything of ROS is loaded: it says how to install what isn't there
            from grip_gui.live.inspector import RosInspector

            with opening:
                if not looker:
                    looker.append(RosInspector())
            return {"value": getattr(looker[0], do)(**fields) or {}}
        except (GripError, ValueError, OSError, ImportError, ExpectedError) as error:
            return {"error": reason_of(error)}
        except Exception as error:  # noqa: BLE001 - one question that can't be answered ends no other
            return {"error": f"{type(error).__name__}: {error}"}

    def work(number: int, do: str, fields: dict[str, Any]) -> None:
        line = json.dumps({"id": number, **found(do, fields)})
        with speaking:
            answers.write(line + "\n")
            answers.flush()

    with ThreadPoolExecutor(WORKERS, "look") as pool:
        for line in sys.stdin:
            asked = json.loads(line)
            pool.submit(work, asked.pop("id"), asked.pop("do"), asked)
    if looker:
        looker[0].close()
    return 0


if __name__ == "__main__":
    status = main()
    sys.stderr.flush()
    os._exit(status)  # what hangs in a thread of a library keeps nobody waiting
