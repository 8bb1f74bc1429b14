"""What a restructuring gives: the task, where its nodes have gone, and what stayed as it was."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from grip_bt.base.errors import NotExpressibleError
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.writer import WIDTH
from grip_bt.compilers.machine_table import leads
from grip_bt.compilers.resolve import Part
from grip_bt.task import dumps
from grip_bt.task.model import AnyNode, Fallback, Sequence, StateMachine, Task, join

Place = tuple[str, ...]
"""A node's names, from some node above it downwards."""


COMMON = (StateMachine.model_fields.keys() & Sequence.model_fields.keys()) - {"kind", "children", "outcomes"}
"""What a state machine and a composite say in the same way."""


@dataclass(frozen=True)
class Note:
    """A container that kept its kind.

    Attributes:
        reason: why it has no equal in the other form; a phrase without a full stop.
        by_design: whether its kind never changes, such as a decorator's; nothing is missing then.
        edges: of a state machine: those without which it would have a structure.
    """

    path: str
    kind: str
    reason: str
    by_design: bool = False
    edges: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.path}: this {self.kind} stays: {self.reason}"


@dataclass(frozen=True)
class Restructured:
    """A task in another form; `paths` lead from where each node was to where it is."""

    task: Task
    paths: Mapping[str, str]
    notes: tuple[Note, ...]

    def require_all(self, target: str) -> None:
        """Refuse a task of which a part has no equal in the form `target`.

        Raises:
            NotExpressibleError: for the first such part.
        """
        for note in self.notes:
            if not note.by_design:
                raise NotExpressibleError(note.path, f"this {note.kind} ({note.reason})", target)


@dataclass(frozen=True)
class Built:
    """A node in its new form.

    Attributes:
        places: path of each old node, from here downwards -> its names below `node`.
    """

    node: AnyNode
    places: Mapping[str, Place] = field(default_factory=dict)

    def below(self, place: Place) -> dict[str, Place]:
        return {old: (*place, *names) for old, names in self.places.items()}


def is_within(path: str, above: str) -> bool:
    """Tell whether a node is another one or in it."""
    return above in ("/", path) or path.startswith(f"{above}/")


def paths_of(root: Built) -> dict[str, str]:
    """Return old path -> new path."""
    result = {}
    for old, names in root.places.items():
        path = "/"
        for name in names:
            path = join(path, name)
        result[old] = path
    return result


def kept(part: Part, children: Mapping[str, Built]) -> Built:
    """Return a container of the same kind around its new children."""
    places: dict[str, Place] = {part.path: ()}
    for name, child in children.items():
        places.update(child.below((name,)))
    if not children:
        return Built(part.node, places)
    nodes = FrozenDict({name: child.node for name, child in children.items()})
    key = "child" if hasattr(part.node, "child") else "children"
    return Built(part.node.model_copy(update={key: nodes}), places)


def common(node: Sequence | Fallback | StateMachine) -> dict[str, object]:
    """Return what stays as it is when a composite becomes a state machine, or the reverse."""
    return {key: getattr(node, key) for key in COMMON}


def successors(part: Part) -> list[str]:
    """Return the children that a sibling leads to.

    Without any, a container ends in the same tick as its child, whatever its kind is.
    """
    ways = [way for index in range(len(part.children)) for _, _, way in leads(part, index)]
    return list(dict.fromkeys(way.to for way in ways if way.to is not None))


def to_text(result: Restructured, form: str, source: str) -> str:
    """Return the file of a restructured task.

    Args:
        form: what it was made into, such as `a behaviour tree`.
    """
    return "".join(f"{line}\n" for line in _header(result, form, source)) + dumps(result.task)


def _header(result: Restructured, form: str, source: str) -> Iterator[str]:
    if not result.notes:
        yield from _comment(f"{source} as {form}; nothing had to stay as it was.")
        return
    yield from _comment(f"{source} as {form}. What kept its kind, and why:")
    reasons: dict[str, list[str]] = {}
    for note in result.notes:
        reasons.setdefault(note.reason, []).append(f"{result.paths[note.path]} ({note.kind})")
    for reason, places in reasons.items():
        yield from _comment(f"{', '.join(places)}: {reason}.", "- ")


def _comment(text: str, mark: str = "") -> list[str]:
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=f"# {mark}",
        subsequent_indent="# " + " " * len(mark),
        break_long_words=False,
        break_on_hyphens=False,
    )
