"""Leaves that exported files import: scripted ones, of grip's kind and of plain py_trees."""

from __future__ import annotations

from typing import Any, ClassVar

from parity_world import ScriptedLeaf, World
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import DataError


class GripScripted(ScriptedLeaf):
    """As in the tests of parity; the run's world is its context."""

    def setup(self, **kwargs: Any) -> None:
        self.world = kwargs["context"]
        super().setup(**kwargs)

    def _seen(self, port: str) -> Any:
        try:
            return self.read(port)
        except (DataError, LookupError):
            return "-"


class PlainScripted(Behaviour):
    """The same as a behaviour that knows nothing of grip; it is recognised by its script."""

    world: ClassVar[World]
    paths: ClassVar[dict[str, str]]
    step: dict[str, Any] | None = None
    outcome: str | None = None
    code: str | None = None

    def __init__(self, name: str, script: str):
        super().__init__(name)
        self.script, self.path = script, self.paths[script]

    def initialise(self) -> None:
        self.outcome = self.code = None
        self.k, self.step = self.world.begin(self.path, self.script)
        self.ticks = self.step.get("ticks", 0)

    def update(self) -> Status:
        assert self.step is not None
        if self.step.get("stops"):
            self.world.stopped = True
            return Status.RUNNING
        self.world.clock.advance(self.step.get("advance", 0))
        if self.ticks:
            self.ticks -= 1
            return Status.RUNNING
        if self.step.get("raises"):
            raise RuntimeError(f"{self.path} breaks")
        self.outcome, code = self.step["outcome"], self.step.get("code")
        self.note(self.outcome, code)
        self.step = None
        failed = self.outcome in ("failure", "lost")
        self.code = code if failed else None
        return Status.FAILURE if failed else Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.step is not None:
            self.note("halted", None)
            self.step = None

    def note(self, outcome: str, code: str | None) -> None:
        self.world.trace.append((self.path, self.k, (), outcome, code, self.world.preempt_requested))
