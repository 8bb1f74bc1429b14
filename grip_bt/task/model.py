"""The task document as frozen models; the models' fields are the file's keys. `grip_bt.task.validation` checks meaning.

A node is a leaf (`node:`) or a container (`kind:`). Nodes have no names of their own: the key under which a
container holds a child is its name, and the path of names is its identity (`attempt/grasp`). The root's path is `/`.

Outcomes. Every node ends with one of its outcomes, a label whose meaning is `success` or `failure`. A leaf's come
from its manifest. A composite or decorator ends with `success` or `failure`, and with whatever `outcomes` adds;
`exits` maps `child.outcome` or `child.outcome.code` to one of its outcomes and ends it at once; a label that isn't
mapped acts by its meaning. A `state_machine` ends with the `outcomes` it declares and nothing else. `on` of a child
of a state machine maps its `outcome` or `outcome.code` to a sibling or to an outcome of the machine; `on` of the
root maps to the outcomes of the task.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict

from .kinds import KINDS as KINDS
from .kinds.base import Decorator as Decorator
from .kinds.base import Kind as Kind
from .kinds.base import Leaf as Leaf
from .kinds.base import Node as Node
from .kinds.cooldown import Cooldown as Cooldown
from .kinds.for_each import ForEach as ForEach
from .kinds.force import Force as Force
from .kinds.foreign import Foreign as Foreign
from .kinds.guard import Guard as Guard
from .kinds.invert import Invert as Invert
from .kinds.loop import Loop as Loop
from .kinds.parallel import Parallel as Parallel
from .kinds.parallel import ParallelRule as ParallelRule
from .kinds.repeat import Repeat as Repeat
from .kinds.retry import Retry as Retry
from .kinds.sequence import Fallback as Fallback
from .kinds.sequence import Sequence as Sequence
from .kinds.state_machine import StateMachine as StateMachine
from .kinds.subtask import Subtask as Subtask
from .kinds.switch import Switch as Switch
from .kinds.timeout import Timeout as Timeout
from .parts import FORMAT_VERSION as FORMAT_VERSION
from .parts import Case as Case
from .parts import Meaning as Meaning
from .parts import Name as Name
from .parts import Shape as Shape
from .parts import Variable as Variable
from .parts import WithFreeKeys as WithFreeKeys
from .parts import type_of as type_of

Container = Kind
AnyNode = Leaf | Kind
Childless = Leaf | Foreign | Subtask
"""Nodes that hold no children in the document."""


class Task(WithFreeKeys):
    """One task: what one file holds."""

    grip: Literal[1]
    name: str
    doc: str = ""
    outcomes: FrozenDict[Name, Meaning] = Field(
        default=FrozenDict({"success": "success", "failure": "failure"}), min_length=1
    )
    inputs: FrozenDict[Name, Variable | str] = FrozenDict()
    """Variables that are given from outside; one with an initial value needn't be."""
    outputs: FrozenDict[Name, Variable | str] = FrozenDict()
    """Variables whose values are handed out at the end."""
    data: FrozenDict[Name, Variable | str] = FrozenDict()
    root: Node

    @field_validator("grip", mode="before")
    @classmethod
    def _version_is_a_number(cls, value: Any) -> Any:
        if type(value) is not int:  # true and 1.0 equal 1
            raise ValueError(f"the version of the format is a whole number, `grip: {FORMAT_VERSION}`")
        return value

    @model_validator(mode="after")
    def _variables_are_declared_once(self) -> Task:
        for name in (*self.inputs, *self.outputs):
            if name in self.data:
                raise ValueError(f"{name!r} is a port and stands in `data` too; remove it from `data`")
        for name in self.inputs:
            if name in self.outputs and type_of(self.inputs[name]) != type_of(self.outputs[name]):
                raise ValueError(f"{name!r} goes in and comes out as one variable; give both the same type")
        return self

    @property
    def variables(self) -> Mapping[str, Variable | str]:
        """The variables of the whole task: inputs, outputs and data."""
        return {**self.outputs, **self.inputs, **self.data} if self.inputs or self.outputs else self.data
