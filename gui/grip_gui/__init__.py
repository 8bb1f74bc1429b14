"""The editor's server: shows a project's tasks in a browser, runs each in a process of its own, live and in replay."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grip_gui.server import serve
    from grip_gui.wire.runs import RunOptions

_HOME = {"serve": "server", "RunOptions": "wire.runs"}
__all__ = ["RunOptions", "serve"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'grip_gui' has no attribute {name!r}")
    return getattr(import_module(f"grip_gui.{_HOME[name]}"), name)
