"""What the editor's server costs, and whether it stays as it is.

    .venv/bin/python benchmarks/gui_load.py soak|status|idle [--seconds N] [--viewers N]

* `soak`: runs of a task one after the other while viewers look on; every event must reach every viewer, in order and
  once, and the server's memory must stay flat.
* `status`: 200 running nodes say how it goes 30 times a second, one viewer looks on.
* `idle`: one viewer looks on and nothing runs.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
from websockets.asyncio.client import ClientConnection, connect

from grip_bt.runtime import Journal

NODES, RATE = 200, 30.0
WARM_UP = 0.2
"""Part of a soak after which memory is looked at first."""
PATIENCE = 120.0
"""How long anything may take on a machine that does much else [s]."""
_TICKS = os.sysconf("SC_CLK_TCK")
_TASK = """\
grip: 1
name: turns
data: {count: {type: int, value: 0}}
root:
  kind: repeat
  times: 40
  child:
    both:
      kind: parallel
      children:
        one: {node: flow/wait, with: {seconds: 0.02}}
        two: {node: flow/wait, with: {seconds: 0.03}}
"""


@dataclass
class Server:
    """A `grip edit` of a project of its own."""

    process: subprocess.Popen[str]
    folder: Path
    http: httpx.AsyncClient
    origin: str
    cookie: str

    def megabytes(self) -> float:
        """Return its resident memory [MB]."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return float(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1]) / 1024

    def cpu(self) -> float:
        """Return the time that its threads have computed [s]."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / _TICKS

    def socket(self, page: str) -> Any:
        """Return a connection of one viewer."""
        headers = {"cookie": self.cookie, "origin": self.origin}
        url = self.origin.replace("http", "ws") + f"/api/socket?page={page}"
        return connect(url, additional_headers=headers, max_size=None)


@asynccontextmanager
async def serving() -> AsyncIterator[Server]:
    """Serve a project; at the end it is stopped as a person would."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "tasks").mkdir()
        (folder / "grip.yaml").write_text("grip: 1\n")
        (folder / "tasks" / "turns.yaml").write_text(_TASK)
        command = [sys.executable, "-m", "grip_bt.cli", "edit", str(folder), "--no-browser"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert process.stdout is not None
        url = next(line.strip() for line in process.stdout if "http://" in line)
        origin = url.partition("/?")[0]
        async with httpx.AsyncClient(base_url=origin, headers={"origin": origin}, timeout=PATIENCE) as http:
            await http.get(url.removeprefix(origin), follow_redirects=True)
            cookie = "; ".join(f"{name}={value}" for name, value in http.cookies.items())
            try:
                yield Server(process, folder, http, origin, cookie)
            finally:
                process.send_signal(signal.SIGINT)
                _, said = process.communicate(timeout=PATIENCE)
                if process.returncode != 0 or "Traceback" in said:
                    raise AssertionError(f"the server ended with {process.returncode}: {said}")


@dataclass
class Looker:
    """One viewer: takes the events of each run as it begins, and checks that none is missing or twice."""

    name: str
    events: int = 0
    runs: int = 0
    complete: set[str] = field(default_factory=set)
    _run: str = ""
    _next: int = 1

    async def look(self, server: Server) -> None:
        """Look on until it is cancelled."""
        async with server.socket(self.name) as socket:
            async for text in socket:
                await self._heard(json.loads(text), socket)

    async def _heard(self, frame: dict[str, Any], socket: ClientConnection) -> None:
        if frame["type"] == "session" and frame["session"] and frame["session"]["run"] not in (None, self._run):
            self._run, self._next = frame["session"]["run"], 1
            self.runs += 1
            await socket.send(json.dumps({"type": "subscribe", "run": self._run, "from_seq": 1}))
        elif frame["type"] == "events" and frame["run"] == self._run:
            for event in frame["events"]:
                if event["seq"] != self._next:
                    raise AssertionError(f"{self.name}: event {event['seq']} instead of {self._next} of {self._run}")
                self._next += 1
            self.events += len(frame["events"])
            if frame["complete"]:
                self.complete.add(self._run)


async def soak(seconds: float, viewers: int) -> dict[str, Any]:
    """Run a task again and again before viewers.

    Returns:
        what was seen; memory in MB.

    Raises:
        AssertionError: a viewer has missed something, or a run didn't end well.
    """
    async with serving() as server:
        lookers = [Looker(f"viewer{i}") for i in range(viewers)]
        tasks = [asyncio.create_task(looker.look(server)) for looker in lookers]
        start, memory, runs = time.monotonic(), 0.0, 0
        request = {"task": "tasks/turns.yaml", "robot": "fake", "page": "viewer0"}
        while time.monotonic() - start < seconds or runs < 2:
            run = await _one_run(server, request)
            runs += 1
            if not memory and time.monotonic() - start > WARM_UP * seconds:
                memory = server.megabytes()
            deadline = time.monotonic() + PATIENCE
            while any(run not in looker.complete for looker in lookers):
                failed = [task for task in tasks if task.done()]
                if failed or time.monotonic() > deadline:
                    raise AssertionError(f"viewers have missed the end of {run}: {failed or 'too late'}")
                await asyncio.sleep(0.02)
        after = server.megabytes()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        return {
            "viewers": viewers,
            "seconds": round(time.monotonic() - start, 1),
            "runs": runs,
            "events": sum(looker.events for looker in lookers),
            "memory_warm": round(memory, 1),
            "memory_end": round(after, 1),
        }


async def _one_run(server: Server, request: dict[str, Any]) -> str:
    """Run the task to its end; return the run's id."""
    answer = await server.http.post("/api/session", json=request)
    if answer.status_code != 201:
        raise AssertionError(answer.text)
    while (view := (await server.http.get("/api/session")).json())["state"] != "ended":
        await asyncio.sleep(0.05)
    if view["status"] != "success":
        raise AssertionError(f"a run ended with {view['status']}: {view['message']}")
    return str(view["run"])


async def status(seconds: float, viewers: int) -> dict[str, Any]:
    """Measure the server while many nodes say how it goes."""
    async with serving() as server:
        with Journal(server.folder / ".grip" / "runs.sqlite") as journal:
            text = (server.folder / "tasks" / "turns.yaml").read_text()
            log = journal.begin("turns", "tasks/turns.yaml", text, "bt", 0)
            log.append(0.0, "/", "run_started")
            journal.flush()
            lookers = [Looker(f"viewer{i}") for i in range(viewers)]
            tasks = [asyncio.create_task(_watch(server, looker, log.id)) for looker in lookers]
            await asyncio.sleep(1.0)
            start, cpu, frames = time.monotonic(), server.cpu(), 0
            while (now := time.monotonic() - start) < seconds:
                for node in range(NODES):
                    log.append(now, f"node_{node}", "message", data={"text": f"at {now:.2f}"})
                frames += 1
                await asyncio.sleep(max(0.0, frames / RATE - (time.monotonic() - start)))
            share = (server.cpu() - cpu) / (time.monotonic() - start)
            log.end("success", None)
        await asyncio.sleep(2.0)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        seen = sum(looker.events for looker in lookers)
        return {"viewers": viewers, "written": frames * NODES, "seen": seen, "share_of_a_core": round(share, 3)}


async def _watch(server: Server, looker: Looker, run: str) -> None:
    async with server.socket(looker.name) as socket:
        looker._run = run
        await socket.send(json.dumps({"type": "subscribe", "run": run, "from_seq": 1}))
        async for text in socket:
            await looker._heard(json.loads(text), socket)


async def idle(seconds: float, viewers: int) -> dict[str, Any]:
    """Measure the server while nothing happens."""
    async with serving() as server:
        lookers = [Looker(f"viewer{i}") for i in range(viewers)]
        tasks = [asyncio.create_task(looker.look(server)) for looker in lookers]
        await asyncio.sleep(2.0)
        cpu, start = server.cpu(), time.monotonic()
        await asyncio.sleep(seconds)
        share = (server.cpu() - cpu) / (time.monotonic() - start)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        return {"viewers": viewers, "share_of_a_core": round(share, 4), "memory": round(server.megabytes(), 1)}


MODES = {"soak": (soak, 3600.0, 20), "status": (status, 15.0, 1), "idle": (idle, 30.0, 1)}


def main() -> None:
    """Run what the command line names, and print its figures with the machine's load."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mode", choices=MODES)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--viewers", type=int)
    args = parser.parse_args()
    measure, seconds, viewers = MODES[args.mode]
    print(f"load of this machine: {' '.join(f'{part:.1f}' for part in os.getloadavg())}")
    print(json.dumps(asyncio.run(measure(args.seconds or seconds, args.viewers or viewers))))


if __name__ == "__main__":
    main()
