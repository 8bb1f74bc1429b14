"""How this Python is started once more, and how such a process has ended."""

from __future__ import annotations

import signal
import sys


def python_command(*words: str) -> list[str]:
    """Return the command of a child process in this Python.

    Without `-P` Python puts the current folder in front of its path for `-m` and `-c`: a `random.py` beside a task
    would take the place of Python's, and one that a stranger has put there would be run. What a child is to find
    there, it adds itself, at the end.

    Args:
        *words: such as `-m`, a module, and its arguments.
    """
    return [sys.executable, "-P", *words]


def how_ended(status: int) -> str:
    """Return how a process ended, by its `returncode`: `was ended by SIGKILL (Killed)`, `ended with exit status 1`."""
    if status >= 0:
        return f"ended with exit status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = str(-status)
    return f"was ended by {name} ({signal.strsignal(-status)})"
