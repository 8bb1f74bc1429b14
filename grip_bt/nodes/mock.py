"""A leaf that plays a script in place of a node: outcomes, reasons, outputs and durations, activation by activation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from py_trees.common import Status
from pydantic import BaseModel, ConfigDict, Field

from grip_bt.base.types import Value
from grip_bt.base.values import Failure
from grip_bt.task.catalog.manifest import Manifest

from .leaf import Leaf


class MockStep(BaseModel):
    """How activations of a mocked node go, as a file says it."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)
    outcome: str = "success"
    """Label of the outcome."""
    code: str = ""
    """Of the failure; empty for none."""
    message: str = ""
    """Of the failure, for people."""
    outputs: dict[str, Value] = {}
    """Port -> value, written at the end."""
    seconds: Annotated[float, Field(ge=0)] = 0.0
    """How long it takes on the run's clock [s]."""
    times: Annotated[int, Field(ge=1)] = 1
    """How many activations go like this."""


class MockLeaf(Leaf):
    """Plays the steps, at least one, one after the other; the last one goes on for ever."""

    _until = 0.0

    def __init__(self, name: str, path: str, manifest: Manifest, meaning: Mapping[str, str], steps: Sequence[MockStep]):
        super().__init__(name, path, manifest, {}, meaning)
        self.steps, self.activations = tuple(steps), 0
        self._step = self.steps[0]

    def initialise(self) -> None:
        self._step, number = self.steps[-1], self.activations
        for step in self.steps:
            if number < step.times:
                self._step = step
                break
            number -= step.times
        self.activations += 1
        self._until = self.context.clock.now() + self._step.seconds
        if self._step.seconds:
            self.context.wake_at(self._until)

    def resume(self, began: float) -> None:
        self.initialise()
        self._until = began + self._step.seconds
        if self._step.seconds:
            self.context.wake_at(self._until)

    def replay_ended(self, outcome: str | None) -> None:
        self.activations += 1

    def update(self) -> Status:
        if self._step.seconds and self.context.clock.now() < self._until:
            return self.running("mock")
        step = self._step
        self.observer.message(self.path, f"mock: {step.outcome}" + (f".{step.code}" if step.code else ""))
        if self.meaning[step.outcome] == "failure" and (step.code or step.message):
            self.failure = Failure(step.code or "failed", step.message or "mocked", {})
        return self.end(step.outcome, **step.outputs)
