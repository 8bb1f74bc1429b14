"""A task of the first GRIP as it was meant, whichever of its forms it was read from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["changed", "missing"]


@dataclass(frozen=True)
class Note:
    """Something that isn't as it was.

    Attributes:
        kind: `changed`: it is done another way, or corrected; `missing`: somebody has to look at it.
        place: what it is about: a path in the task, a file.
        text: what, and what to do.
    """

    kind: Kind
    place: str
    text: str

    def __str__(self) -> str:
        return f"{self.kind:<8} {self.place}: {self.text}"


@dataclass
class OriginalState:
    """One state.

    Attributes:
        name: its label.
        type: its class, such as `ComputePlan`, or the name of a component, a sensor or a state of the user's.
        slots: what its fields hold.
        outcomes: in order: the first is the good one, the last the bad one.
        leads: outcome -> label of a state, or outcome of the container.
    """

    name: str
    type: str
    slots: dict[str, Any] = field(default_factory=dict)
    outcomes: list[str] = field(default_factory=list)
    leads: dict[str, str] = field(default_factory=dict)


@dataclass
class OriginalContainer(OriginalState):
    """A container; `outcomes` are its own, `leads` say where these go in its parent.

    Attributes:
        concurrent: whether its children run at once.
        children: by label.
        initial: where it starts; all children of a concurrent one do.
        default: of a concurrent one: the outcome where no rule holds.
        rules: of a concurrent one: outcome -> child -> its outcomes, any of which will do.
    """

    concurrent: bool = False
    children: dict[str, OriginalState] = field(default_factory=dict)
    initial: str = ""
    default: str = ""
    rules: dict[str, dict[str, list[str]]] = field(default_factory=dict)

    def states(self) -> Iterator[OriginalState]:
        """Yield every state below, containers not."""
        for child in self.children.values():
            if isinstance(child, OriginalContainer):
                yield from child.states()
            else:
                yield child
