"""Tasks of the first GRIP as they were meant: the graphs of its editor, in `.ini` files."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictInt, StrictStr, ValidationError

from grip_bt.base.errors import GripError
from grip_bt.formats.imported import Issues
from grip_bt.formats.names import free, node_name
from grip_bt.task.model import Meaning

from .settings import Key, Refused


@dataclass
class GripState:
    """One state; its type is a class, a component, a sensor or a state of the user's.

    The first of its outcomes is the good one, the last the bad one; each leads to a state or outcome of the container.
    `reads` and `writes` are keys of the userdata, where the file names them.
    """

    name: str
    type: str
    slots: dict[str, Any] = field(default_factory=dict)
    outcomes: list[str] = field(default_factory=list)
    leads: dict[str, str] = field(default_factory=dict)
    reads: list[str] = field(default_factory=list)
    writes: list[str] = field(default_factory=list)


@dataclass
class GripContainer(GripState):
    """A container; `outcomes` are its own, `leads` say where these go in its parent.

    Of a concurrent one, `rules` are outcome -> child -> its outcomes, any of which will do; `default` where none holds.
    """

    concurrent: bool = False
    children: dict[str, GripState] = field(default_factory=dict)
    initial: str = ""
    default: str = ""
    rules: dict[str, dict[str, list[str]]] = field(default_factory=dict)

    def states(self) -> Iterator[GripState]:
        """Yield every state below, containers not."""
        for child in self.children.values():
            if isinstance(child, GripContainer):
                yield from child.states()
            else:
                yield child


_GOOD = ("succ", "suces")
_BAD = ("fail", "abort", "error", "none", "preempt", "quit", "unsucc")


def name_of(label: str, taken: Collection[str] = ()) -> str:
    """Return a label as a task may spell it, none of those that are taken."""
    return free(node_name(label), taken)


def outcome_meanings(outcomes: Sequence[str]) -> dict[str, Meaning]:
    """Return what outcomes mean: by their names; else the first is good, and the last of several bad."""
    found: dict[str, Meaning] = {}
    for number, outcome in enumerate(outcomes):
        bad, good = (any(word in outcome.lower() for word in words) for words in (_BAD, _GOOD))
        last = number == len(outcomes) - 1 and number > 0
        found[outcome] = "failure" if bad or (last and not good) else "success"
    return found


def is_hand(group: str) -> bool:
    """Tell whether a group of joints is a hand, by its name."""
    return any(word in group.lower() for word in ("hand", "gripper", "finger")) and "arm" not in group.lower()


CONCURRENT = "ConcurrentStateMachine"
_START = "Start"
DEEPEST = 30
"""Most containers that may lie in each other."""
Role = tuple[str, str, str]
"""Of a socket: `start`, `end`, `in` or `out`; the state; the outcome."""
Sockets = dict[int | str | None, Role]

# outcomes of the states that came with it, in their order
OUTCOMES = {"Counter": ["success", "finished"]}


class BrokenTaskError(GripError):
    """A task of the first GRIP can't be read; the message says what and where."""


@contextmanager
def broken_if_invalid(place: str) -> Iterator[None]:
    """Say in words what pydantic says of data."""
    try:
        yield
    except ValidationError as error:
        first = error.errors()[0]
        raise BrokenTaskError(f"{place}: {'/'.join(map(str, first['loc']))}: {first['msg']}") from None


def graph_task(settings: Mapping[Key, object], source: str, issues: Issues) -> GripContainer:
    """Return the task that a file of settings holds. Raises BrokenTaskError: there is none in it, or it is broken."""
    graphs: dict[Key, dict[str, object]] = {}
    for key, value in settings.items():
        if key[-1] != "container":
            continue
        if isinstance(value, Refused):
            raise BrokenTaskError(f"{source}:{value.line}: {'/'.join(key)}: {value.reason}")
        if not isinstance(value, dict):
            raise BrokenTaskError(f"{source}: {'/'.join(key)} is a {type(value).__name__} and not a graph")
        graphs[key[:-1]] = value
    if not graphs:
        raise BrokenTaskError(f"{source}: there is no task in it: no key ends with `container`")
    root = min(graphs, key=len)
    return _Reader(graphs, source, issues).container(root[-1] if root else "root", "StateMachine", root, 0)


class _Said(BaseModel):
    model_config = ConfigDict(extra="ignore")


class _Socket(_Said):
    id: StrictInt | StrictStr
    name: str = ""


_AnySocket = Annotated[_Socket, BeforeValidator(lambda said: said if isinstance(said, dict) else {"id": said})]


class _Entry(_Said):
    name: str = Field(min_length=1)
    type: str = ""
    content: dict[str, object] = {}
    input_socket: _AnySocket | None = None
    output_sockets: list[_AnySocket] = []


class _Connector(_Said):
    start: Any = None
    end: object = None


class _Graph(_Said):
    terminal_sockets: list[_Socket]
    states: list[_Entry] = []
    state_machines: list[_Entry] = []
    connectors: list[_Connector] = []


class _Reader:
    def __init__(self, graphs: Mapping[Key, dict[str, object]], source: str, issues: Issues):
        self.graphs, self.source = graphs, source
        self.issues = issues

    def container(self, name: str, kind: str, key: Key, depth: int) -> GripContainer:
        if depth > DEEPEST:
            raise BrokenTaskError(f"{self.source}: containers lie in each other more than {DEEPEST} deep")
        place = "/".join(key)
        with broken_if_invalid(f"{self.source}: {place}"):
            graph = _Graph.model_validate(self.graphs[key])
        ends = [each.name for each in graph.terminal_sockets]
        start = ends.index(_START) if _START in ends else 0
        outcomes = [end for number, end in enumerate(ends) if number != start and end]
        made = GripContainer(name, kind, outcomes=outcomes, concurrent=kind == CONCURRENT)
        sockets: Sockets = {}
        for number, terminal in enumerate(graph.terminal_sockets):
            role = ("start", "", "") if number == start else ("end", "", ends[number])
            self._socket(sockets, terminal, role, place)
        for entry in graph.states:
            self._child(made, GripState(entry.name, entry.type, dict(entry.content)), entry, sockets, place)
        for entry in graph.state_machines:
            inner = self.container(entry.name, entry.type or "StateMachine", self._find(entry.name, key), depth + 1)
            self._child(made, inner, entry, sockets, place)
        self._finish(made, self._connect(made, graph.connectors, sockets, place), place)
        return made

    def _find(self, name: str, parent: Key) -> Key:
        """Return the key of a container: below or beside the one that names it, or the only one of this name."""
        found = [key for key in self.graphs if key[-1:] == (name,)]
        near = [key for key in ((*parent, name), (*parent[:-1], name), (name,)) if key in found]
        if not near and len(found) != 1:
            raise BrokenTaskError(f"{self.source}: the container {name!r} isn't in the file")
        return (near or found)[0]

    def _socket(self, sockets: Sockets, said: _Socket, role: Role, place: str) -> None:
        if sockets.setdefault(said.id, role) != role:
            raise BrokenTaskError(f"{self.source}: {place}: two sockets have the id {said.id!r}; save the task again")

    def _child(self, made: GripContainer, child: GripState, entry: _Entry, sockets: Sockets, place: str) -> None:
        if child.name in made.children:
            raise BrokenTaskError(f"{self.source}: {place}: two states are called {child.name!r}")
        made.children[child.name] = child
        if entry.input_socket is not None:
            self._socket(sockets, entry.input_socket, ("in", child.name, ""), place)
        names = [socket.name for socket in entry.output_sockets]
        names = names if all(names) else _usual(child, len(names))
        if not isinstance(child, GripContainer):
            child.outcomes = names
        for socket, outcome in zip(entry.output_sockets, names, strict=True):
            self._socket(sockets, socket, ("out", child.name, outcome), place)

    def _connect(self, made: GripContainer, connectors: list[_Connector], sockets: Sockets, place: str) -> list[str]:
        """Follow the connectors; return where the container starts."""
        starts = []
        for entry in connectors:
            pair = [role for role in (sockets.get(_id(entry.start)), sockets.get(_id(entry.end))) if role is not None]
            if len(pair) < 2:
                self.issues.add("incomplete", place, "a connector leads nowhere and was left out")
                continue
            left, right = sorted(pair, key=lambda role: role[0] not in ("start", "out"))
            if left[0] == "start" and right[0] == "in":
                starts.append(right[1])
            elif left[0] == "out" and right[0] in ("in", "end"):
                (_, child, outcome), target = left, right[1] if right[0] == "in" else right[2]
                made.children[child].leads[outcome] = target
                if made.concurrent and right[0] == "end":
                    made.rules.setdefault(target, {}).setdefault(child, []).append(outcome)
                elif made.concurrent:
                    what = "in a concurrent container, whose children begin at once"
                    self.issues.add("changed", place, f"{outcome!r} of {child!r} led to {target!r} {what}")
            else:
                self.issues.add("incomplete", place, f"a connector joins {left[0]} and {right[0]}: left out")
        return starts

    def _finish(self, made: GripContainer, starts: list[str], place: str) -> None:
        for what, there in (("is empty", made.children), ("has no outcomes", made.outcomes)):
            if not there:
                raise BrokenTaskError(f"{self.source}: {place}: the container {what}")
        made.initial, made.default = (starts or list(made.children))[0], made.outcomes[-1]
        if made.concurrent:
            made.rules.pop(made.default, None)
            text = f"which outcome was the default isn't in such a file; {made.default!r}, the last one, is used"
            self.issues.add("changed", place, text)
        elif len(starts) != 1:
            text = f"Start leads to {starts or 'nothing'}; {made.initial!r} is used as the initial state"
            self.issues.add("incomplete", place, text)


def _usual(child: GripState, count: int) -> list[str]:
    """Return the outcomes of a state whose file only counts them."""
    known = child.outcomes if isinstance(child, GripContainer) else OUTCOMES.get(child.type, [])
    if len(known) == count:
        return known
    return ["success", "failure"] if count == 2 else [*map(str, range(count - 1)), "state_failure"]


def _id(said: object) -> int | str | None:
    found = said.get("id") if isinstance(said, dict) else said
    return found if isinstance(found, int | str) else None
