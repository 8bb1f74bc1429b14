"""What a node of a task is: its fields as a frozen model and, of a container, a pure automaton over its children.

An automaton answers five questions, and each answer is a step:

* `begin(state, q)`: no child runs. `state` is None when the container is entered, else what `Next` said a tick ago.
* `ended(state, child, end, q)`: a child that was run has ended.
* `again(state, running, q)`: a further tick, before any child is ticked; only asked of kinds that are `reactive`.
* `settle(state, q)`: every child was ticked and nothing has ended the container; only asked of kinds that `settle`,
  and of those that are `concurrent` only where a child has ended since.
* `over(state, q)` is told, once, that an activation has ended or was halted.

A kind holds no state of its own and never compares data: it asks `q`. A run answers from its variables and its clock;
an exploration (`grip_bt.task.exploration`) answers with everything in turn. So the behaviour tree, the state machine,
the analyses and the drawings all come from the one automaton. It asks all its questions before it puts a value:
whoever resumes a run may ask twice.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, NamedTuple, Protocol, TypeAlias

from pydantic import BaseModel, Discriminator, Field, GetCoreSchemaHandler, Tag
from pydantic_core import CoreSchema
from typing_extensions import TypeAliasType

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import Value

from ..parts import Case, Meaning, Name, Variable, WithFreeKeys

if TYPE_CHECKING:
    from grip_bt.base.values import Failure

State: TypeAlias = Any
"""What a kind keeps while it is active: what it was answered, such as a count, a moment or what is left of a list."""
CHILD: Final = object()
"""The reason of an end: that of the child which has ended last."""


class Run(NamedTuple):
    """Tick these children now, in this order; those that run and aren't among them are halted: before, with `first`."""

    children: tuple[int, ...]
    state: State = 0
    first: bool = False


class Next(NamedTuple):
    """No child is ticked any more in this tick; `begin(state)` is asked in the next one, which is asked for at once."""

    state: State


class Stay(NamedTuple):
    """Everything stays as it is."""

    state: State


class End(NamedTuple):
    """The container has ended."""

    outcome: str
    reason: object = CHILD
    """A `Reason`, the failure of a child, None, or `CHILD`."""


class Reason(NamedTuple):
    """Why a container fails by itself."""

    code: str
    text: str


class Ended(NamedTuple):
    """How a child has ended."""

    child: str
    outcome: str
    meaning: str
    code: str | None = None
    failure: Failure | None = None


ChildEnds = Sequence[Sequence[tuple[Ended, str | None]]]
"""For each child, how it can end, and the outcome that an exit of the container makes of that."""
Step = Run | Next | Stay | End


class Questions(Protocol):
    """What a kind may ask.

    Attributes:
        names: of the children, in order.
        ends: how each child has ended, None where it hasn't; kept for kinds that are `concurrent`.
        kept: what a kind keeps from one activation to the next; None at first.
    """

    kept: State

    @property
    def names(self) -> Sequence[str]: ...  # the children's names
    @property
    def ends(self) -> Sequence[Ended | None]: ...  # how the children have ended
    def at(self, name: str) -> int: ...  # the position of a child
    def now(self) -> State: ...  # the time of the run's clock
    def deadline(self, seconds: float) -> State: ...  # the time in so many seconds, and have the task ticked then
    def passed(self, at: State) -> bool: ...  # whether a time has come
    def up(self, count: State) -> State: ...  # one more
    def reached(self, count: State, limit: int) -> bool: ...  # whether a count has come to its limit
    def pick(self, count: State, size: int) -> int: ...  # the count modulo `size`
    def holds(self, key: str) -> bool: ...  # whether the condition at a key is true
    def value(self, key: str) -> Value: ...  # what the expression at a key evaluates to
    def match(self, key: str, literals: Sequence[tuple[str, Case]], default: str) -> str:
        """Return the name of the first literal that equals the value at a key, else `default`."""

    def items(self, key: str) -> State: ...  # the items of the list that the variable at a key holds
    def empty(self, left: State) -> bool: ...  # whether no items are left
    def take(self, left: State) -> tuple[Value, State]: ...  # the first item, and what is left then
    def put(self, key: str, value: Value) -> None: ...  # write the variable at a key
    def exit(self, end: Ended) -> str | None: ...  # the outcome that an end is mapped to by `exits`, or None
    def edge(self, end: Ended) -> str: ...  # where an end leads by the child's `on`: a sibling or an outcome
    def ask(self, text: str) -> None: ...  # request the children that still run to stop; `text` says why


class BaseNode(WithFreeKeys):
    """What every node has."""

    doc: str = ""
    precondition: str = ""
    """An expression over the variables around the node; where it is false on entry, the node fails at once."""
    on: FrozenDict[str, str] = FrozenDict()


class Leaf(BaseNode):
    """A node of the catalogue."""

    node: str
    """Catalogue id, such as `arm/lift`."""
    with_: FrozenDict[str, Value] = Field(default=FrozenDict(), alias="with")
    """Literal parameters."""
    in_: FrozenDict[str, str] = Field(default=FrozenDict(), alias="in")
    """Input port -> variable."""
    out: FrozenDict[str, str] = FrozenDict()
    """Output port -> variable."""
    meaning: FrozenDict[str, Meaning] = FrozenDict()
    """Outcome -> meaning, where it differs from the manifest's."""


Shown = Literal["Composite", "Sequence", "Selector", "Parallel", "Decorator"]


class Kind(BaseNode):
    """The base of every kind of container.

    Attributes:
        title: what it is called on the page, where that isn't what stands in the document.
        sign: stands for the kind in text.
        icon: stands for it in pictures: an SVG path in a square of 16.
        example: the fields with which an editor inserts one.
        keeps_codes: whether it fails with its children's codes too.
        conditions: fields that are expressions and true or false.
        values: fields that are other expressions.
        reads: fields that name a variable which holds a list.
        puts: fields that name a variable of the container's own, it holds an
            item of the list at `reads`.
        shown: which class of py_trees its behaviour is.
        resets: whether all children are reset on entry, as py_trees' Sequence and Parallel do.
        by_edges: whether the children's own `on` says where their ends lead.
        concurrent: whether children run at the same time; `Questions.ends` is kept for it.
        late_exits: whether `exits` are the kind's own to ask for; else they are taken as soon as a child has ended.
    """

    rank: ClassVar[int] = 1000
    title: ClassVar[str] = ""
    sign: ClassVar[str] = ""
    icon: ClassVar[str] = ""
    example: ClassVar[Mapping[str, object]] = {}
    codes: ClassVar[tuple[str, ...]] = ()
    keeps_codes: ClassVar[bool] = True
    conditions: ClassVar[tuple[str, ...]] = ()
    values: ClassVar[tuple[str, ...]] = ()
    reads: ClassVar[tuple[str, ...]] = ()
    puts: ClassVar[tuple[str, ...]] = ()
    shown: ClassVar[Shown] = "Composite"
    resets: ClassVar[bool] = False
    by_edges: ClassVar[bool] = False
    concurrent: ClassVar[bool] = False
    late_exits: ClassVar[bool] = False

    if TYPE_CHECKING:  # each kind has these as fields, or as constants where a document can't say them
        kind: str

        @property
        def data(self) -> FrozenDict[Name, Variable | str]: ...
        @property
        def outcomes(self) -> FrozenDict[Name, Meaning]: ...
        @property
        def exits(self) -> FrozenDict[str, str]: ...

    @classmethod
    def kind_name(cls) -> str:
        return str(cls.model_fields["kind"].annotation.__args__[0])  # type: ignore[union-attr]

    @property
    def below(self) -> FrozenDict[Name, Node]:
        """The children by name, in order."""
        return FrozenDict()

    @property
    def reactive(self) -> bool:
        """Whether it is asked again at the beginning of every tick."""
        return False

    @property
    def settles(self) -> bool:
        """Whether it is asked after every tick of its children."""
        return False

    @property
    def blocking(self) -> bool:
        """Whether blocking states can do the same: nothing is looked at while a child runs."""
        return not self.reactive and not self.settles

    @property
    def joins(self) -> bool:
        """Whether it runs all its children at once and ends when all have ended."""
        return False

    @property
    def may_ask(self) -> bool:
        """Whether it may request children that run to stop."""
        return False

    def begin(self, state: State, q: Questions) -> Step:
        """Return the first step: the first child is run."""
        return Run((0,))

    def ended(self, state: State, child: int, end: Ended, q: Questions) -> Step:
        """Return what follows the end of a child: the container ends with its meaning."""
        return End(end.meaning)

    def again(self, state: State, running: tuple[int, ...], q: Questions) -> Step | None:
        """Return the first step of a further tick; None: those who run go on, and the state is what it was."""
        return None

    def settle(self, state: State, q: Questions) -> Step:
        """Return what follows when every child was ticked: nothing changes."""
        return Stay(state)

    def over(self, state: State, q: Questions) -> None:
        """Note that an activation has ended or was halted."""

    def explorable(self, ends: ChildEnds) -> bool:
        """Tell whether its ways are few enough to be listed; if not, `possible` and `flow` answer for it."""
        return True

    def possible(self, ends: ChildEnds) -> tuple[set[str], int]:
        """Return the outcomes that the children's ends may lead to, and how many children may be run."""
        raise NotImplementedError

    def flow(self, ends: ChildEnds, after: Callable[[int, int], Mapping[str, int]], state: int) -> dict[str, int]:
        """Return outcome -> what is surely written then.

        Args:
            after: child, what is written before it -> outcome -> what is written after it, as a set of bits.
            state: what is written on entry.
        """
        raise NotImplementedError

    def all_outcomes(self) -> Mapping[str, Meaning]:
        """Return every outcome that it can end with by itself or by an exit, and its meaning."""
        return {"success": "success", "failure": "failure", **self.outcomes}

    def expressions(self) -> Iterator[tuple[str, str]]:
        """Yield the key and text of each expression over the variables that it sees, its own among them."""
        for field in (*self.conditions, *self.values):
            if getattr(self, field) or type(self).model_fields[field].is_required():
                yield field.rstrip("_"), getattr(self, field)

    def taken(self) -> Iterator[tuple[str, str, str]]:
        """Yield each key that names a variable with a list, that variable, and the container's own for the items."""
        for items, item in zip(self.reads, self.puts, strict=True):
            yield items, getattr(self, items), getattr(self, item)

    def settings(self) -> str:
        """Return its settings in a few words, to stand beside its kind; empty where the kind says it all."""
        return ""

    def words(self) -> str:
        settings = self.settings()
        return self.kind.replace("_", " ") + (f": {settings}" if settings else "")

    def lines(self) -> list[str]:
        """Return further lines about it."""
        return []


def every_kind(base: type[Kind] = Kind) -> list[type[Kind]]:
    """Return the classes of all kinds that were imported, in their order."""
    found = [made for below in base.__subclasses__() for made in every_kind(below)]
    if "kind" in vars(base).get("__annotations__", {}) and base is not Kind:
        found.append(base)
    return sorted(found, key=lambda made: (made.rank, made.__name__))


def _tag(value: object) -> str | None:
    if isinstance(value, BaseModel):
        return getattr(value, "kind", "leaf")
    if isinstance(value, dict):
        return str(value["kind"]) if "kind" in value else "leaf"
    return None


if TYPE_CHECKING:
    Node = Leaf | Kind
else:

    class _AnyKind:
        """The union of all nodes, made when a model is first used: then every kind is there."""

        @staticmethod
        def __get_pydantic_core_schema__(source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
            nodes: object = (
                Annotated[Leaf, Tag("leaf")],
                *(Annotated[made, Tag(made.kind_name())] for made in every_kind()),
            )
            before = sys.getrecursionlimit()
            sys.setrecursionlimit(before + 100)  # pydantic makes the schema of each kind within that of another
            try:
                return handler.generate_schema(Annotated[reduce(or_, nodes), Discriminator(_tag)])
            finally:
                sys.setrecursionlimit(before)

    Node = TypeAliasType("Node", Annotated[Any, _AnyKind])  # by name: kinds hold nodes, which are kinds


class Declaring(Kind):
    """What has variables and outcomes of its own."""

    data: FrozenDict[Name, Variable | str] = FrozenDict()
    """Variables: a type, or a type with an initial value."""
    outcomes: FrozenDict[Name, Meaning] = FrozenDict()


class Composite(Declaring):
    """What has any number of children."""

    children: FrozenDict[Name, Node]
    exits: FrozenDict[str, str] = FrozenDict()

    @property
    def below(self) -> FrozenDict[Name, Node]:
        return self.children


class Decorator(Declaring):
    """What has one child, and does something with its result."""

    shown: ClassVar[Shown] = "Decorator"
    child: FrozenDict[Name, Node] = Field(min_length=1, max_length=1)
    exits: FrozenDict[str, str] = FrozenDict()

    @property
    def below(self) -> FrozenDict[Name, Node]:
        return self.child
