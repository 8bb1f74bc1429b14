"""What to do about a component that didn't come up."""

from __future__ import annotations

import re

from grip_bt.base.failures import ExpectedError, UnfitServerError
from grip_bt.task.catalog.component_file import ComponentFile

from .starting import uses_our_python

_MISSING = re.compile(r"No module named '(\w+)'")


def advice(file: ComponentFile, error: ExpectedError, alive: bool, said: str) -> str:
    """Return what to do, to be put behind an error's message; empty where the message says it.

    Args:
        file: the component.
        error: why there is no server.
        alive: whether a process of ours runs that should serve it.
        said: what that process printed last.
    """
    starts = file.start is not None and file.start.run
    if isinstance(error, UnfitServerError):
        return _about_type(file, str(error.data.get("serves", "")))
    if "waited" not in error.data:
        return _about_end(file, said) if starts else ""
    if not starts:
        off = (
            "take `run: false` out of its `start`" if file.start is not None else "say under `start` how it is started"
        )
        return f". Start it, or {off} (component.yaml of {file.name})"
    if alive:
        return (
            f". Its process runs: does it serve {file.server} (`server`), as {file.interface} (`interface`), and in "
            "time (`timeouts: {ready: SECONDS}`)?"
        )
    return ""


def _about_type(file: ComponentFile, serves: str) -> str:
    if not serves or serves == file.interface:
        return ""
    return (
        f". If that is meant: `interface: {serves}` in component.yaml of {file.name}, then `grip component add` again"
    )


def _about_end(file: ComponentFile, said: str) -> str:
    """Return what to do about a process that ended instead of serving."""
    assert file.start is not None
    program = file.start.command[0] if file.start.command else ""
    missing = _MISSING.search(said)
    if missing is None:
        return "" if said else "\nA server runs until it is stopped; this one ended by itself."
    own = missing[1] in ("rclpy", "std_msgs", "std_srvs", file.interface.partition("/")[0])
    if own and program and not uses_our_python(file.start):
        return (
            f"\n{program!r} is a Python without ROS or the built interfaces: write "
            '"{python}" in `command` for the one that runs GRIP, or name one that has them'
        )
    return (
        f"\n{missing[1]!r} isn't installed for the Python that runs it: install it there, or name another in `command`"
    )
