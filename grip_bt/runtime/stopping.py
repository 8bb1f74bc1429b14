"""The certain end of a run: leaves are terminated from outside, and what hangs is found and left behind."""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import GripError
from grip_bt.compilers import Halted
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Observer

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Zombie:
    """A leaf whose code hasn't returned when the run was over.

    Attributes:
        where: the function that hangs, such as `update` or `terminate`; `worker` for blocking code of an operation.
    """

    path: str
    where: str

    def __str__(self) -> str:
        return f"{self.path} ({self.where})"


class EndedObserver(Observer):
    """The observer of a run that is over: whatever comes back from where it hung gets no further."""

    def entered(self, path: str) -> None:
        raise Halted


class _ClosedContext:
    def __getattr__(self, name: str) -> Any:
        raise Halted


def in_background(what: str, action: Callable[[], object]) -> threading.Thread:
    """Call `action()` in a daemon thread of its own; what it raises is logged, with its traceback if it is a bug."""

    def work() -> None:
        try:
            action()
        except Halted:
            pass  # a leaf that was left behind
        except GripError as error:  # such as a simulator that is gone
            _log.warning("%s: %s", what, error)
        except BaseException:  # noqa: BLE001 - there is nobody who could do anything about it
            _log.exception("%s", what)

    thread = threading.Thread(target=work, name="grip_stop", daemon=True)
    thread.start()
    return thread


def join_all(threads: Iterable[threading.Thread], deadline: float) -> None:
    """Wait for threads, at most until `deadline` [s, monotonic]."""
    for thread in threads:
        thread.join(max(0.0, deadline - time.monotonic()))


def terminate_outside(leaves: Mapping[str, Leaf]) -> list[threading.Thread]:
    """Call `terminate` of every active leaf, each in a thread of its own, so that none keeps another waiting."""
    return [
        in_background(f"terminate of {path}", lambda leaf=leaf: leaf.terminate(Status.INVALID))  # type: ignore[misc]
        for path, leaf in leaves.items()
        if leaf.active
    ]


def lock_out(leaves: Mapping[str, Leaf]) -> None:
    """Have leaves do nothing more, whoever still calls them."""
    for leaf in leaves.values():
        leaf.context = _ClosedContext()
        leaf.status, leaf.active = Status.INVALID, False


def code_running(leaves: Mapping[str, Leaf], threads: Iterable[int] | None = None) -> dict[str, str]:
    """Return path -> function for each leaf in whose code one of some threads is now; by default all but this one."""
    paths = {id(leaf): path for path, leaf in leaves.items()}
    own = threading.get_ident()
    found: dict[str, str] = {}
    for thread, frame in sys._current_frames().items():
        if thread == own or (threads is not None and thread not in threads):
            continue
        inner: Any = frame
        while inner is not None:
            if inner.f_code.co_varnames[:1] == ("self",):
                path = paths.get(id(inner.f_locals.get("self")))
                if path is not None and inner.f_code.co_name not in _OURS:
                    found[path] = inner.f_code.co_name
            inner = inner.f_back
    return found


_OURS = ("tick", "tick_once", "stop", "setup", "_abandon", "begin", "conclude")
"""What calls an author's code: outside of it, and never what hangs."""


def left_working(leaves: Mapping[str, Leaf]) -> list[Zombie]:
    """Return the leaves whose interrupted operations haven't ended."""
    return [Zombie(path, "worker") for path, leaf in leaves.items() if leaf.zombie]


def still_moving(leaves: Mapping[str, Leaf]) -> list[str]:
    """Return the leaves whose interrupted operations may move something and haven't ended."""
    return [path for path, leaf in leaves.items() if leaf.manifest.may_move and leaf.unended]
