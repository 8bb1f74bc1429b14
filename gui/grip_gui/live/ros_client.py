"""A process that looks at ROS for the page: started when it is asked first, ended when nobody has asked for long.

`python -m grip_gui.live.ros_client` is that process. Native code that breaks in it takes no page down.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import sys
import threading
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.interpreter import how_ended
from grip_gui.processes import ChildProcess, reason_of

IDLE = 60.0
"""How long it stays without a question [s]; a connection to ROS takes a second to come up, and costs a little CPU."""
PATIENCE = 60.0  # longest time to an answer [s]
LONGEST_LINE = 1 << 26
CLOSING = 5.0  # how long it may take to end [s]
WORKERS = 4  # questions at a time: one that waits for a message keeps no other waiting


class RosClientError(GripError):
    """The process that looks at ROS can't, or says why something can't be done."""


class RosClientProcess:
    """Asks the process, which works in the project's folder; all methods belong to the event loop.

    Attributes:
        kept: whether the process stays also when nobody asks for `idle` seconds, because it serves something.
    """

    def __init__(self, project: Path, idle: float = IDLE):
        self._project, self._idle, self.kept = project, idle, False
        self._process: ChildProcess | None = None
        self._waiting: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._numbers = itertools.count(1)
        self._starting = asyncio.Lock()
        self._ending: asyncio.TimerHandle | None = None
        self._lives: set[asyncio.Task[None]] = set()

    async def ask(self, do: str, **fields: object) -> dict[str, Any]:
        """Return the answer to a question; RosClientError says why there is none."""
        async with self._starting:
            process = self._process or await self._start()
        number, answer = next(self._numbers), asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        try:
            await process.send({"id": number, "do": do, **fields})
            async with asyncio.timeout(PATIENCE):
                found = await answer
        except TimeoutError:
            raise RosClientError(f"no answer within {PATIENCE:g} s") from None
        finally:
            self._waiting.pop(number, None)
            if self._ending is not None:
                self._ending.cancel()
            self._ending = asyncio.get_running_loop().call_later(self._idle, self._end_idle)
        if "error" in found:
            raise RosClientError(found["error"])
        return dict(found["value"])

    async def close(self) -> None:
        """End the process; afterwards none is left, nor one that was ending for want of questions."""
        if self._ending is not None:
            self._ending.cancel()
        self._end()
        if self._lives:
            await asyncio.wait(self._lives)

    async def _start(self) -> ChildProcess:
        process = self._process = await ChildProcess.start(
            "grip_gui.live.ros_client", folder=self._project, longest=LONGEST_LINE
        )
        self._let_live(self._live(process))
        return process

    def _let_live(self, life: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(life)
        self._lives.add(task)
        task.add_done_callback(self._lives.discard)

    async def _live(self, process: ChildProcess) -> None:
        listening = asyncio.create_task(process.follow(self._heard))
        status = await process.wait()
        await asyncio.wait([listening], timeout=CLOSING)
        listening.cancel()
        if self._process is process:
            self._process = None
        elif self._process is not None:
            return  # another one answers what is waited for now
        said = process.tail().rpartition("\n")[2]
        for number in list(self._waiting):
            await self._heard({"id": number, "error": f"the ROS process {how_ended(status)}{said and ': ' + said}"})

    async def _heard(self, found: dict[str, Any]) -> None:
        waiting = self._waiting.get(found.get("id", 0))
        if waiting is not None and not waiting.done():
            waiting.set_result(found)

    def _end_idle(self) -> None:
        if not self.kept and not self._waiting:
            self._end()

    def _end(self) -> None:
        """Let the process end; one that doesn't is killed."""
        process, self._process = self._process, None
        if process is not None:
            process.say_no_more()
            self._let_live(self._see_to_end(process))

    async def _see_to_end(self, process: ChildProcess) -> None:
        try:
            async with asyncio.timeout(CLOSING):
                await process.wait()
        except TimeoutError:
            await process.kill()


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
