"""Whether the process that executes a run is there, for whoever reads its journal: later, or from another process."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def process_facts() -> dict[str, Any]:
    """Return who this process is, for whoever wants to know later whether it lives."""
    return {"pid": os.getpid(), "since": _begun(os.getpid()), "host": socket.gethostname()}


def is_there(facts: Mapping[str, Any]) -> bool | None:
    """Tell whether a process is there; None where that isn't known, such as of another machine.

    Args:
        facts: of `process_facts`.
    """
    pid, since = facts.get("pid"), facts.get("since")
    if facts.get("host") != socket.gethostname() or type(pid) is not int or type(since) is not int:
        return None
    return _begun(pid) == since


def _begun(pid: int) -> int | None:
    """Return when a process began [ticks since boot]; None when there is none.

    One that has ended and whose parent hasn't taken note of it doesn't count: in a container nobody may ever.
    """
    try:
        facts = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return None if facts[0] in "ZX" else int(facts[19])
    except (OSError, ValueError, IndexError):
        return None
