"""A client of services, actions and topics that isn't ours, in a shell that has sourced one file: nothing else."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PROGRAM = Path(__file__).parent / "ros" / "data" / "plain_service_client.py"


@contextmanager
def service_client(setup: Path) -> Iterator[Callable[..., Any]]:
    """Give a function that calls, publishes or hears, by type and name, in a process of its own; see `PROGRAM`."""
    clean = {name: os.environ[name] for name in ("PATH", "HOME")}
    with subprocess.Popen(
        ["bash", "-c", f'source "{setup}"; exec "{sys.executable}" "{PROGRAM}"'],
        env=clean,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as client:
        assert client.stdin is not None
        assert client.stdout is not None

        def ask(kind: str, name: str, /, **fields: object) -> Any:
            client.stdin.write(json.dumps([kind, name, fields]) + "\n")
            client.stdin.flush()
            line = client.stdout.readline()
            assert line, "the client has ended"
            return json.loads(line)

        yield ask
        client.kill()
