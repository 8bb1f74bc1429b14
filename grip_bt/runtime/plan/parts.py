"""What a compiled node is, and the pieces that every kind shares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from .kinds import Kind
from .watch import Methods

if TYPE_CHECKING:
    from .builtin import Builtin

S, F, R, INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID
VALID = tuple(Status)

Visit = Callable[[Behaviour], None]


@dataclass(frozen=True)
class Verdict:
    """What a parent makes of a child that yields, which matters for children that are ticked by their own generator.

    Attributes:
        leave: at these statuses of a child that yields itself, the parent leaves the child's generator for good.
        onward: what a child that was never left has said.
    """

    leave: tuple[Status, ...] = ()
    onward: Status = S


@dataclass(frozen=True)
class Part:
    """A compiled node.

    Attributes:
        node: what was compiled.
        tick: does what its `tick` does; returns the status that the parent goes by.
        halt: does what `stop(INVALID)` does.
        inside: what source can be generated from; None where the node is left to `tick`.
        relink: where no source is written for a node: makes its `tick` anew, from children ticked in another way.
    """

    node: Any
    tick: Callable[[], Status]
    halt: Callable[[], None]
    inside: Inside | None = None
    relink: Callable[[list[Part]], Callable[[], Status]] | None = None


@dataclass(frozen=True)
class Inside:
    """A node as it was when it was compiled.

    Attributes:
        kind: its rules.
        kids: its compiled children.
        stop: does what its `stop` does.
        methods: those of its children.
        initialises: whether it overrides `initialise`.
        terminates: whether it overrides `terminate`.
        memory: of a sequence or selector.
        policy: of a parallel.
        ours: whether it reports to an observer and ends with labels.
        exits: whether ends of its children may end it at once.
        builtin: what stands for the `update` of a leaf of py_trees' own.
    """

    kind: Kind
    kids: tuple[Part, ...]
    stop: Callable[[Status], None]
    methods: Methods
    initialises: bool
    terminates: bool
    memory: Any = None
    policy: Any = None
    ours: bool = False
    exits: bool = False
    builtin: Builtin | None = None


def rejected(node: Behaviour, status: Any) -> Status:
    """Return INVALID and complain, as py_trees does about what isn't a status."""
    node.logger.error(f"A behaviour returned an invalid status, setting to INVALID [{status}][{node.name}]")
    return INVALID


def foreign(node: Behaviour, verdict: Verdict, visit: Visit | None) -> Callable[[], Status]:
    """Tick by the node's own generator."""

    def tick() -> Status:
        steps = node.tick()
        for yielded in steps:
            if visit is not None:
                visit(yielded)
            if yielded is node and node.status in verdict.leave:
                return node.status
        return verdict.onward

    return tick


def halt_foreign(node: Behaviour) -> Callable[[], None]:
    """Stop by the node's own `stop`."""

    def halt() -> None:
        node.stop(INVALID)

    return halt
