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
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, Discriminator, Field, StringConstraints, Tag, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict

from .parts import FORMAT_VERSION as FORMAT_VERSION
from .parts import Case as Case
from .parts import Meaning as Meaning
from .parts import Name as Name
from .parts import ParallelRule as ParallelRule
from .parts import Shape as Shape
from .parts import Variable as Variable
from .parts import type_of as type_of


class _Node(Shape):
    doc: str = ""
    precondition: str = ""
    """An expression over the variables around the node; where it is false on entry, the node fails at once."""
    on: FrozenDict[str, str] = FrozenDict()
    x: FrozenDict[str, Any] = Field(default=FrozenDict(), description="free data, preserved and never read")


class Leaf(_Node):
    """A node of the catalogue."""

    node: str
    """Catalogue id, such as `arm/lift`."""
    with_: FrozenDict[str, Any] = Field(default=FrozenDict(), alias="with")
    """Literal parameters."""
    in_: FrozenDict[str, str] = Field(default=FrozenDict(), alias="in")
    """Input port -> variable."""
    out: FrozenDict[str, str] = FrozenDict()
    """Output port -> variable."""
    meaning: FrozenDict[str, Meaning] = FrozenDict()
    """Outcome -> meaning, where it differs from the manifest's."""


class _Container(_Node):
    data: FrozenDict[Name, Variable | str] = FrozenDict()
    """Variables: a type, or a type with an initial value."""
    outcomes: FrozenDict[Name, Meaning] = FrozenDict()


class _Composite(_Container):
    children: FrozenDict[Name, Node]
    exits: FrozenDict[str, str] = FrozenDict()


class Decorator(_Container):
    """What has one child, and does something with its result."""

    child: FrozenDict[Name, Node] = Field(min_length=1, max_length=1)
    exits: FrozenDict[str, str] = FrozenDict()


class Sequence(_Composite):
    """Children in order until one fails. With `memory: false` the first child is asked again on every tick."""

    kind: Literal["sequence"]
    memory: bool = True


class Fallback(_Composite):
    """Children in order until one succeeds. With `memory: false` the first child is asked again on every tick."""

    kind: Literal["fallback"]
    memory: bool = True


class Parallel(_Composite):
    """All children at once.

    `all` succeeds when every child has succeeded and fails when one has failed; `any` succeeds when one has
    succeeded and fails when every child has failed. What is decided is decided after all children were ticked. Then
    `halt` interrupts the children that are still running, `ask` requests them to stop and waits for them, and `join`
    waits. Where there are `rules`, the first that matches decides, and `policy` only what none of them does.
    """

    kind: Literal["parallel"]
    policy: Literal["all", "any"] = "all"
    rules: list[ParallelRule] = Field(default_factory=list)
    wait_for: Literal["all", "any"] | Annotated[int, Field(ge=1)] | list[Name] | None = None
    """Who has to have ended before anything is decided: all, one, so many, or these; then it is decided."""
    cancel: Literal["halt", "ask", "join"] = "halt"
    order: Literal["declared"] | None = None
    """`declared`: children may share variables, since they are ticked in their order."""
    retick: bool = False
    """Children that have ended are activated again on every tick, until it is decided."""
    prompt: bool = False
    """Decided after each child rather than after all of them: the later ones are not ticked any more."""

    @model_validator(mode="after")
    def _join_waits_for_all(self) -> Parallel:
        if self.cancel == "join" and self.wait_for not in (None, "all"):
            raise ValueError("`cancel: join` waits for all children; remove `wait_for`, or use `cancel: ask`")
        if self.prompt and self.cancel != "halt":
            raise ValueError("`prompt` halts what still runs at once; remove it, or use `cancel: halt`")
        if self.retick and (self.prompt or self.cancel != "halt"):
            raise ValueError("`retick` goes with `cancel: halt` and without `prompt`; remove it, or these")
        return self


class StateMachine(_Container):
    """One child at a time; each child's `on` says who is next."""

    kind: Literal["state_machine"]
    initial: str
    outcomes: FrozenDict[Name, Meaning] = Field(min_length=1)
    children: FrozenDict[Name, Node] = Field(min_length=1)


class Retry(Decorator):
    """The child again, at most `times` times in all, until it succeeds; one attempt a tick."""

    kind: Literal["retry"]
    times: int = Field(ge=1)


class Repeat(Decorator):
    """The child again, `times` times in all or until it fails; without `times`, for ever. One attempt a tick."""

    kind: Literal["repeat"]
    times: int | None = Field(default=None, ge=1)


class Timeout(Decorator):
    """Fails with the reason `time_out` when the child is still running after `seconds` of the run's clock.

    The clock is looked at once a tick, before the child: from the deadline on nothing in it begins or goes on.
    """

    kind: Literal["timeout"]
    seconds: float = Field(gt=0)
    child_first: bool = False
    """The child is ticked before the clock is looked at, as by py_trees: what ends at the deadline has ended."""


class Guard(Decorator):
    """Fails with the reason `guard` when `if` is false; looked at on every tick, before the child."""

    kind: Literal["guard"]
    if_: str = Field(alias="if")
    """An expression over variables."""


class Switch(_Composite):
    """The one child whose case equals the value on entry; else `default`, or a failure with the reason `no_case`.

    With `memory: false` the value is looked at on every tick; where it leads to another child, the running one is
    halted first.
    """

    kind: Literal["switch"]
    on_value: str
    """An expression over variables."""
    cases: FrozenDict[str, Case | list[Case]]
    """Child -> the literal, or one of the literals, for which it is taken."""
    default: str = ""
    """The child that is taken for every other value."""
    memory: bool = True
    children: FrozenDict[Name, Node] = Field(min_length=1)


class ForEach(Decorator):
    """The child once for each item of a list, one a tick, until it fails; an empty list runs nothing and succeeds."""

    kind: Literal["for_each"]
    items: str
    """The variable that holds the list, as it is on entry."""
    item: Name
    """The variable that holds the item for the child; it is this container's own."""

    @model_validator(mode="after")
    def _item_is_new(self) -> ForEach:
        if self.item in self.data:
            raise ValueError(f"`item` declares {self.item!r}; remove it from `data`")
        return self


class Loop(Decorator):
    """The child again and again, one pass a tick: while a condition holds, until it fails or an exit is taken.

    After `times` passes it fails with the reason `loop_limit`, unless the condition has become false.
    """

    kind: Literal["loop"]
    while_: str = Field(default="", alias="while")
    """An expression over variables, looked at before each pass."""
    times: int | None = Field(default=None, ge=1)


class Cooldown(Decorator):
    """After the child has ended or was halted it isn't run for `seconds`: until then the container fails at once."""

    kind: Literal["cooldown"]
    seconds: float = Field(gt=0)


class Foreign(_Node):
    """Somebody's own behaviour of py_trees; it ends with `success` or `failure`, and knows no variables."""

    kind: Literal["foreign"]
    behaviour: Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_.]*:[A-Za-z_][A-Za-z0-9_.]*$")]
    """Where it is imported from when the task is compiled: `package.module:Class`, or a function that makes one."""
    args: FrozenDict[str, Any] = FrozenDict()
    """Literal arguments by name."""
    children: ClassVar[FrozenDict[str, Node]] = FrozenDict()
    data: ClassVar[FrozenDict[str, Variable | str]] = FrozenDict()
    outcomes: ClassVar[FrozenDict[str, Meaning]] = FrozenDict()
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()


class Subtask(_Node):
    """Another task file of the project as one node: its inputs and outputs are ports, its outcomes are the node's.

    It has variables of its own: inputs are copied in on entry, outputs are copied out when it ends, never after a halt.
    """

    kind: Literal["subtask"]
    task: Annotated[str, StringConstraints(min_length=1)]
    """The file, relative to the project's folder, such as `tasks/fetch.yaml`."""
    with_: FrozenDict[str, Any] = Field(default=FrozenDict(), alias="with")
    """Input -> literal."""
    in_: FrozenDict[str, str] = Field(default=FrozenDict(), alias="in")
    """Input -> variable."""
    out: FrozenDict[str, str] = FrozenDict()
    """Output -> variable."""
    meaning: FrozenDict[str, Meaning] = FrozenDict()
    """Outcome -> meaning, where it differs from the file's."""
    children: ClassVar[FrozenDict[str, Node]] = FrozenDict()
    data: ClassVar[FrozenDict[str, Variable | str]] = FrozenDict()
    outcomes: ClassVar[FrozenDict[str, Meaning]] = FrozenDict()
    exits: ClassVar[FrozenDict[str, str]] = FrozenDict()


class Invert(Decorator):
    """Success becomes failure and failure becomes success."""

    kind: Literal["invert"]


class Force(Decorator):
    """Ends with `as`, whatever the child ended with."""

    kind: Literal["force"]
    as_: Meaning = Field(alias="as")


def _tag(value: Any) -> str | None:
    if isinstance(value, BaseModel):
        return getattr(value, "kind", "leaf")
    if isinstance(value, dict):
        return str(value["kind"]) if "kind" in value else "leaf"
    return None


Node = Annotated[
    Annotated[Leaf, Tag("leaf")]
    | Annotated[Sequence, Tag("sequence")]
    | Annotated[Fallback, Tag("fallback")]
    | Annotated[Parallel, Tag("parallel")]
    | Annotated[StateMachine, Tag("state_machine")]
    | Annotated[Retry, Tag("retry")]
    | Annotated[Repeat, Tag("repeat")]
    | Annotated[Timeout, Tag("timeout")]
    | Annotated[Guard, Tag("guard")]
    | Annotated[Switch, Tag("switch")]
    | Annotated[ForEach, Tag("for_each")]
    | Annotated[Loop, Tag("loop")]
    | Annotated[Cooldown, Tag("cooldown")]
    | Annotated[Foreign, Tag("foreign")]
    | Annotated[Subtask, Tag("subtask")]
    | Annotated[Invert, Tag("invert")]
    | Annotated[Force, Tag("force")],
    Discriminator(_tag),
]

Container = (Sequence | Fallback | Parallel | Switch | StateMachine | ForEach) | (
    Retry | Repeat | Loop | Timeout | Guard | Cooldown | Foreign | Subtask | Invert | Force
)
AnyNode = Leaf | Container
Childless = Leaf | Foreign | Subtask
"""Nodes that hold no children in the document."""
KINDS = (
    "sequence", "fallback", "parallel", "state_machine", "retry", "repeat", "timeout", "guard", "switch", "for_each",
    "loop", "cooldown", "foreign", "subtask", "invert", "force",
)  # fmt: skip


class Task(Shape):
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
    x: FrozenDict[str, Any] = Field(default=FrozenDict(), description="free data, preserved and never read")

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
