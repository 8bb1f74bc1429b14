"""Code of somebody, run in a process of its own that tells what it saw as JSON.

That process isn't a sandbox: whoever asks for it trusts the code. It keeps ours clean of whatever the code imports,
starts or leaves behind, and can be stopped.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grip_bt.base.interpreter import python_command

TIMEOUT = 60.0
"""How long [s] the code may take."""


@dataclass(frozen=True)
class Answer:
    """What the process told: the last JSON object on a line of its stdout; `status` is None where it was stopped."""

    data: dict[str, Any] | None
    stderr: str
    status: int | None


def last_json(module: str, arguments: Sequence[str], paths: Sequence[Path] = (), timeout: float = TIMEOUT) -> Answer:
    """Run a module of GRIP's in a process of its own and return what it told; what it had told in time, at least.

    Args:
        paths: where the process looks for modules, after all others.
        timeout: how long [s] it may take.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([*filter(None, sys.path), *map(str, paths)])}
    command, status = python_command("-m", module, *arguments), None
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=timeout, env=environment, stdin=subprocess.DEVNULL
        )
        output, words, status = done.stdout, done.stderr, done.returncode
    except subprocess.TimeoutExpired as error:
        output, words = (
            part.decode(errors="replace") if isinstance(part, bytes) else part or ""
            for part in (error.stdout, error.stderr)
        )
        words += f"stopped after {timeout:g} s"
    whole = [line for line in output.split("\n")[:-1] if line.startswith("{")]
    return Answer(json.loads(whole[-1]) if whole else None, words, status)
