"""The construction of a legacy machine: code is run until the machine is whole, and none is executed.

What it builds is found by where it is made, since most programs build their machine in a `main` that executes it.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

from grip_bt import smach_compat
from grip_bt.nodes.dry_run import StandInState
from grip_bt.nodes.smach_source import code_of, prepare_imports, run_as
from grip_bt.nodes.stand_ins import stands_in, unwrapped
from grip_bt.smach_compat import Container, State

CONTAINERS = (smach_compat.StateMachine, smach_compat.Sequence, smach_compat.Concurrence, smach_compat.Iterator)
_OURS = (str(Path(smach_compat.__file__).parent), os.path.dirname(__file__))


class CaughtError(BaseException):
    """A machine would be executed, so that it is whole."""


class Construction:
    """Notes what is built in this thread, and where, while it is entered; a machine that is executed ends it.

    With `holds_threads` no thread is started at all.

    Attributes:
        made: states and containers, in the order in which they were begun.
        places: id of one of them -> file and line of the code that makes it.
        added: id of a container and label -> where that state was added.
        caught: the machine that was to be executed.
    """

    def __init__(self, ours: tuple[str, ...] = (), holds_threads: bool = False):
        self.made: list[Any] = []
        self.places: dict[int, tuple[str, int]] = {}
        self.added: dict[tuple[int, str], tuple[str, int]] = {}
        self.caught: Any = None
        self._holds_threads = holds_threads
        self._ours, self._thread, self._undo = (*_OURS, *ours, "<"), threading.get_ident(), list[tuple[Any, str, Any]]()

    def __enter__(self) -> Construction:
        begun = State.__init__

        def noting(state: Any, *arguments: Any, **named: Any) -> None:
            if threading.get_ident() == self._thread:
                self.made.append(state)
                self.places[id(state)] = self._place(sys._getframe(1), state)
            begun(state, *arguments, **named)

        self.replace(State, "__init__", noting)
        for cls in (*CONTAINERS, Container):
            if "execute" in vars(cls):
                self.replace(cls, "execute", self._catching(vars(cls)["execute"]))
            for name in ("add", "set_contained_state"):
                if name in vars(cls):
                    self.replace(cls, name, staticmethod(self._adding(vars(cls)[name].__func__)))
        started = threading.Thread.start
        self.replace(threading.Thread, "start", lambda thread: self._started(thread, started))
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> bool:
        while self._undo:
            setattr(*self._undo.pop())
        return kind is CaughtError

    def replace(self, owner: Any, name: str, value: Any) -> None:
        """Set an attribute until the construction is over."""
        self._undo.append((owner, name, vars(owner)[name]))
        setattr(owner, name, value)

    def run(self, code: Callable[[], Any]) -> Any:
        """Run code; return what it returns, or the machine that it was about to execute."""
        with self:
            return code()
        return self.caught

    def built_at(self, file: str, line: int) -> list[object]:
        """Return the containers that were made at a place."""
        there = (file, line)
        return [m for m in self.made if isinstance(m, Container) and self.places[id(m)] == there]

    def given(self, label: Any, state: Any, *rest: Any, **named: Any) -> tuple[Any, ...]:
        """Return what is added, and how, in the place of what the code says."""
        if stands_in(state):
            state = StandInState(label, named.get("transitions", rest[0] if rest else None))
        named = {key: unwrapped(value) for key, value in named.items()}
        return unwrapped(label), state, tuple(map(unwrapped, rest)), named

    def _adding(self, add: Callable[..., object]) -> Callable[..., object]:
        def adding(label: object, state: object, *rest: object, **named: object) -> object:
            if threading.get_ident() != self._thread:
                return add(label, state, *rest, **named)
            label, wanted, rest, named = self.given(label, state, *rest, **named)
            for container in Container._construction_stack[-1:]:
                self.added[id(container), str(label)] = self._place(sys._getframe(1), state)
            add(label, wanted, *rest, **named)
            return state

        return adding

    def _catching(self, execute: Callable[..., object]) -> Callable[..., object]:
        def executing(container: object, *arguments: object, **named: object) -> object:
            if threading.get_ident() != self._thread:
                return execute(container, *arguments, **named)
            self.caught = self.caught or container
            raise CaughtError

        return executing

    def _started(self, thread: threading.Thread, start: Callable[..., None]) -> None:
        if threading.get_ident() != self._thread:
            return start(thread)
        target = getattr(thread, "_target", None)
        owner = getattr(target, "__self__", None)
        if isinstance(owner, Container):
            self.caught = self.caught or owner
            raise CaughtError
        return None if self._holds_threads else start(thread)

    def _place(self, frame: FrameType | None, state: object) -> tuple[str, int]:
        """Return where the code makes the object: outside smach and outside the constructors of its own class."""
        while frame is not None:
            own = next(iter(frame.f_locals.values()), None) is state and frame.f_code.co_name == "__init__"
            if not own and not frame.f_code.co_filename.startswith(self._ours):
                return frame.f_code.co_filename, frame.f_lineno
            frame = frame.f_back
        code = getattr(type(state).__init__, "__code__", None)  # nobody but us makes one of its class
        return ("", 0) if code is None else (code.co_filename, code.co_firstlineno)


def run_as_main(path: Path) -> Callable[[], object]:
    """Return what runs a file as Python does when it is started."""
    return lambda: run_as("__main__", path.resolve(), code_of(path.resolve()), {})


def built_in(path: Path, line: int, code: Callable[[], object], number: int = 0) -> object:
    """Return the `number`th container that code builds at a line of a file; a machine that it would execute ends it.

    Line 0 stands for the machine that it would execute, wherever that is made.

    Raises:
        LookupError: it builds none there, this time.
    """
    prepare_imports(path.resolve())
    construction = Construction()
    construction.run(code)
    found = construction.built_at(str(path.resolve()), line) if line else [construction.caught]
    if number >= len(found) or found[number] is None:
        raise LookupError(f"{path}:{line}: no machine was built there; has the file changed since it was imported?")
    return found[number]
