"""Processes for legacy code: each piece of work in a child, which is ended where it takes too long or only waits."""

from __future__ import annotations

import os
import resource
import select
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path

from pydantic import BaseModel

PATIENCE, BUILDER_PATIENCE = 20, 4
"""How much time of the processor [s] a file, and a builder, may take; of the clock it is ten times as much."""
_LOOK, _IDLE = 0.25, 12
"""How often it is looked whether a child only waits [s], and how many times are too many: nothing else runs here."""


def in_child(work: Callable[[], BaseModel], otherwise: Callable[..., BaseModel], patience: int) -> str:
    """Return, as JSON, what is told by a child of this process; `otherwise` says what its `error` is."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        os.setpgid(0, 0)
        resource.setrlimit(resource.RLIMIT_CPU, (patience + 1, patience + 1))
        try:
            text = work().model_dump_json(exclude_defaults=True)
        except BaseException as error:  # noqa: BLE001 - legacy code may do anything, sys.exit among it
            text = otherwise(error=f"{type(error).__name__}: {error}").model_dump_json()
        with os.fdopen(writer, "wb") as pipe:
            pipe.write(text.encode(errors="replace"))
        os._exit(0)
    os.close(writer)
    parts, end, before, idle = [], time.monotonic() + 10 * patience, "", 0
    why = f"its process ended, perhaps after {patience} s of computing"
    while True:
        if select.select([reader], [], [], _LOOK)[0]:
            part = os.read(reader, 1 << 20)
            if not part:
                break
            parts.append(part)
            continue
        now = _asleep(child)
        before, idle = now, idle + 1 if now and now == before else 0
        if idle >= _IDLE or time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            parts, why = [], "it waits for something" if idle >= _IDLE else f"it was stopped after {10 * patience} s"
            break
    os.close(reader)
    os.waitpid(child, 0)
    return b"".join(parts).decode() or otherwise(error=why).model_dump_json()


def _asleep(process: int) -> str:
    """Return what a process has computed so far, if it sleeps and has no children; empty where it doesn't."""
    try:
        state, *rest = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        children = Path(f"/proc/{process}/task/{process}/children").read_text()
    except OSError:  # no Linux
        return ""
    return " ".join(rest[10:12]) if state == "S" and not children else ""


_loaded: list[str] = []


def load(libraries: list[str]) -> None:
    """Load libraries in this process, so that its children have them."""
    for name in libraries:
        with suppress(Exception, SystemExit):  # it is loaded where it is wanted
            import_module(name)
            _loaded.append(name)


def forget(names: set[str]) -> None:
    """Forget those in the place of which there are files or folders of these names."""
    for name in _loaded:
        if {(top := name.partition(".")[0]), f"{top}.py"} & names:
            sys.modules.pop(name, None)
