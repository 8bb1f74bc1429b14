"""A node's face: ports, parameters, outcomes and documentation. Nobody imports a node to learn these."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.model import Meaning, Name

from .equipment import Names

MOVES = ("arm", "hand", "component", "ros")
"""Groups of built-in nodes whose work reaches beyond this process."""
NodeId = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(/[A-Za-z0-9_]+)+$")]


class _Face(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Parameter(_Face):
    """A literal that a task gives under `with:`."""

    type: str
    doc: str = ""
    default: Any = None
    names: Names | None = None
    """What of the project it names, so that names that aren't there are told before a run."""

    @property
    def required(self) -> bool:
        """Whether a task must give it."""
        return "default" not in self.model_fields_set


class InputPort(_Face):
    """A value that a node reads from the variable bound under `in:`."""

    type: str
    doc: str = ""
    required: bool = True


class OutputPort(_Face):
    """A value that a node writes, when it ends, to the variable bound under `out:`."""

    type: str
    doc: str = ""
    on: tuple[str, ...] = ()
    """Outcomes with which it is written; empty means with every outcome whose meaning is success."""


class Manifest(_Face):
    """One kind of leaf."""

    id: NodeId
    doc: str
    implementation: str
    """Where the leaf is: `package.module:Class`, or `file.py:Class` relative to the manifest's folder."""
    parameters: FrozenDict[str, Parameter] = FrozenDict()
    inputs: FrozenDict[str, InputPort] = FrozenDict()
    outputs: FrozenDict[str, OutputPort] = FrozenDict()
    outcomes: FrozenDict[Name, Meaning] = Field(
        default=FrozenDict({"success": "success", "failure": "failure"}), min_length=1
    )
    codes: tuple[str, ...] = ()
    """Failure codes that it may end with, for completion and checking of `failure.<code>` edges."""
    settings: FrozenDict[str, Any] = FrozenDict()
    """Fixed values that the implementation is made with, for nodes that are generated from one class."""
    resume: Literal["resume", "restart", "ask"] | None = None
    """What is done about an activation of a process that died: the leaf's own `resume`, a new start, or a question.

    Without it: nodes that move something or ask somebody else, and nodes of projects, are asked about; others restart.
    """
    moves: bool | None = None
    """Whether its work may move something, so that it has to have ended, or been stopped, before another begins.

    Without it: built-in nodes of arms and hands, nodes that ask somebody else, and nodes of projects may.
    """
    kind: Literal["leaf"] = "leaf"

    @model_validator(mode="after")
    def _codes_are_of_failures(self) -> Manifest:
        if self.codes and "failure" not in self.outcomes.values():
            raise ValueError("`codes` are those of failures, and no outcome means failure: add one, or remove `codes`")
        return self

    @property
    def may_move(self) -> bool:
        """Whether its work may move something; see `moves`."""
        return self.outside if self.moves is None else self.moves

    @property
    def outside(self) -> bool:
        """Whether its work reaches beyond this process: it moves a robot, asks somebody else, or is a project's own."""
        return self.id.partition("/")[0] in MOVES or not self.implementation.startswith("grip_bt.")

    def outcomes_for(self, meaning: dict[str, Meaning]) -> dict[str, Meaning]:
        """Return the outcomes with a task's own `meaning` applied."""
        return {**self.outcomes, **{k: v for k, v in meaning.items() if k in self.outcomes}}
