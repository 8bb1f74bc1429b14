"""How this Python is started once more: the current folder isn't on its path, whatever modules somebody has in it."""

from __future__ import annotations

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
