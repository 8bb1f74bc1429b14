"""Source of the `update` of decorators of py_trees; the rest is called."""

from __future__ import annotations

from typing import Any

from .writer import Writer


def emit_update(write: Writer, node: Any, name: str, child: str) -> None:
    """Write what leaves the result of the decorator's `update` in `s`."""
    write(f"s = {name}.update()")
