"""The task document as frozen models, whose fields are the file's keys; see docs/task_format.md."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, Literal

from pydantic import Field, PrivateAttr, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.kinds import KINDS as KINDS
from grip_bt.task.kinds.base import Kind as Kind
from grip_bt.task.kinds.base import Leaf as Leaf
from grip_bt.task.kinds.base import Node as Node
from grip_bt.task.kinds.control import Control as Control
from grip_bt.task.kinds.cooldown import Cooldown as Cooldown
from grip_bt.task.kinds.for_each import ForEach as ForEach
from grip_bt.task.kinds.force import Force as Force
from grip_bt.task.kinds.foreign import Foreign as Foreign
from grip_bt.task.kinds.guard import Guard as Guard
from grip_bt.task.kinds.invert import Invert as Invert
from grip_bt.task.kinds.loop import Loop as Loop
from grip_bt.task.kinds.parallel import Parallel as Parallel
from grip_bt.task.kinds.parallel import ParallelRule as ParallelRule
from grip_bt.task.kinds.repeat import Repeat as Repeat
from grip_bt.task.kinds.repeat import Retry as Retry
from grip_bt.task.kinds.sequence import Fallback as Fallback
from grip_bt.task.kinds.sequence import Sequence as Sequence
from grip_bt.task.kinds.state_machine import StateMachine as StateMachine
from grip_bt.task.kinds.subtask import Subtask as Subtask
from grip_bt.task.kinds.switch import Switch as Switch
from grip_bt.task.kinds.timeout import Timeout as Timeout
from grip_bt.task.parts import FORMAT_VERSION as FORMAT_VERSION
from grip_bt.task.parts import Meaning as Meaning
from grip_bt.task.parts import Name as Name
from grip_bt.task.parts import Variable as Variable
from grip_bt.task.parts import WithFreeKeys as WithFreeKeys
from grip_bt.task.parts import type_of as type_of

Container = Kind
AnyNode = Leaf | Kind
Childless = Leaf | Foreign | Subtask
"""Nodes that needn't hold children, and declare no variables."""


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
    _file: str = PrivateAttr("")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Task) and self.__dict__ == other.__dict__  # wherever they were read

    @property
    def file(self) -> str:
        """The file from which it was read; empty where it was made otherwise."""
        return self._file

    def check(self) -> object:
        """Return everything that is wrong with it, by the nodes of its project; see `grip_bt.check`."""
        return _package().check(self)

    def tree(self, **options: object) -> object:
        """Return it as a tree of py_trees that is ready to tick; see `grip_bt.tree`."""
        return _package().tree(self, **options)

    def machine(self, **options: object) -> object:
        """Return it as a state machine that is ready to be executed; see `grip_bt.machine`."""
        return _package().machine(self, **options)

    def show(self, view: Literal["tree", "flow"] = "tree") -> object:
        """Return a picture of it; see `grip_bt.draw`."""
        return _package().draw(self, view)

    def _repr_svg_(self) -> str:
        return str(_package().draw(self).svg)

    @field_validator("grip", mode="before")
    @classmethod
    def _version_is_a_number(cls, value: object) -> object:
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


def _package() -> Any:
    """Return the whole package: what is shown, checked and run knows more than documents."""
    return import_module("grip_bt")


def default_outcome(task: Task, outcome: str, meaning: str) -> str | None:
    """Return the task's outcome for an end of the root that `on` doesn't map: the same word, or else its meaning."""
    return next((target for target in (outcome, meaning) if target in task.outcomes), None)


_NONE: FrozenDict[str, AnyNode] = FrozenDict()


def kind_of(node: AnyNode | Task) -> str:
    """Return a node's kind; `leaf` for a node of the catalogue."""
    return str(getattr(node, "kind", "leaf"))


def children_of(node: AnyNode) -> FrozenDict[str, AnyNode]:
    """Return a node's children by name, in order; empty for a leaf."""
    return _NONE if isinstance(node, Leaf) else node.below


def join(parent: str, name: str) -> str:
    """Return the path of the child `name` of the node at `parent`.

    The root of a task has the path `/`, that of a subtask at `attempt/fetch` has `attempt/fetch/`, and its children
    `attempt/fetch/look`.
    """
    if parent == "/":
        return name
    return f"{parent}{name}" if parent.endswith("/") else f"{parent}/{name}"


def walk(node: AnyNode, path: str = "/") -> Iterator[tuple[str, AnyNode]]:
    """Yield every node below and including `node` with its path, parents first, in document order."""
    stack = [(path, node)]
    while stack:
        path, node = stack.pop()
        yield path, node
        stack.extend((join(path, name), child) for name, child in reversed(children_of(node).items()))


def outcomes_of(node: Container) -> dict[str, Meaning]:
    """Return every outcome that a container can end with, and its meaning; those of a subtask stand in its own file."""
    return with_refusal(node, node.all_outcomes())


def with_refusal(node: AnyNode, outcomes: Mapping[str, Meaning]) -> dict[str, Meaning]:
    """Return a node's outcomes and, where it has a precondition, the `failure` that it then may end with."""
    refusal: dict[str, Meaning] = {"failure": "failure"} if node.precondition else {}
    return {**outcomes, **{k: v for k, v in refusal.items() if k not in outcomes}}


def expressions_of(node: AnyNode) -> Iterator[tuple[str, str]]:
    """Yield the key and text of each expression of a node.

    A `precondition` sees the variables around the node, the others its own too.
    """
    if node.precondition:
        yield "precondition", node.precondition
    if not isinstance(node, Leaf):
        yield from node.expressions()
