"""A component's node run once against a scripted answer: what generated tests and `grip component test` look at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grip_bt.base.operation import Operation
from grip_bt.base.types import JsonObject
from grip_bt.task.catalog.catalog import load_implementation
from grip_bt.task.catalog.manifest import read_manifests


@dataclass(frozen=True)
class Ending:
    """How the node ended.

    Attributes:
        code: why it failed, None otherwise.
        request: what the component was sent, by field.
    """

    outcome: str
    meaning: str
    code: str | None
    message: str
    outputs: JsonObject
    request: JsonObject


class _Scripted:
    """A component that gives one answer, and the run of which the node is a part."""

    preempt_requested = False

    def __init__(self, reply: Mapping[str, object], feedback: Any):
        self.reply, self.feedback = reply, feedback
        self.request: dict[str, Any] = {}

    def call(self, request: Mapping[str, object]) -> Operation[JsonObject]:
        self.request = dict(request)
        operation: Operation[JsonObject] = Operation()
        operation.report(self.feedback)
        operation.succeed(self.reply)
        return operation

    def component(self, name: str) -> _Scripted:
        return self

    def wake(self) -> None:
        """Nobody waits: the answer is there at once."""

    def unfinished(self) -> tuple[str, ...]:
        return ()


def rehearse(
    package: Path, reply: Mapping[str, object], inputs: Mapping[str, object] | None = None, feedback: object = None
) -> Ending:
    """Tick the node of a package until it ends.

    Args:
        package: folder with the node's manifest.yaml.
        reply: the answer's fields as values, with `outcome`.
        inputs: values of the inputs; by default an object for each.
        feedback: the last feedback, of an action.
    """
    (manifest,) = read_manifests(package / "manifest.yaml")
    given = {port: object() for port in manifest.inputs} if inputs is None else inputs
    written: dict[str, object] = {}
    scripted = _Scripted(reply, feedback)
    leaf = load_implementation(manifest)(manifest.id, manifest.id, manifest, {}, {})
    leaf.readers = {port: (lambda value=value: value) for port, value in given.items()}
    leaf.writers = {port: (lambda value, port=port: written.update({port: value})) for port in manifest.outputs}
    leaf.setup(context=scripted)
    leaf.tick_once()
    code, message = (leaf.failure.code, leaf.failure.message) if leaf.failure else (None, "")
    return Ending(leaf.outcome, leaf.meaning[leaf.outcome], code, message, written, scripted.request)
