"""Tasks as the editor of the first GRIP saved them: a graph of sockets and connectors for each container."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictInt, StrictStr, ValidationError

from grip_bt.base.errors import GripError

from .original import Note, OriginalContainer, OriginalState
from .settings import Key, Refused

CONCURRENT = "ConcurrentStateMachine"
_START = "Start"
_DEEPEST = 30
Role = tuple[str, str, str]
"""Of a socket: `start`, `end`, `in` or `out`; the state; the outcome."""
Sockets = dict[int | str | None, Role]

# outcomes of the states that came with it, in their order
OUTCOMES = {"Counter": ["success", "finished"]}


class BrokenTaskError(GripError):
    """A task of the first GRIP can't be read; the message says what and where."""


def graph_task(settings: Mapping[Key, Any], source: str) -> tuple[OriginalContainer, list[Note]]:
    """Return the task that a file of settings holds, and what isn't as it was.

    Raises:
        BrokenTaskError: there is none in it, or it is broken.
    """
    graphs: dict[Key, dict[str, Any]] = {}
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
    reader = _Reader(graphs, source)
    found = reader.container(root[-1] if root else "root", "StateMachine", root, 0)
    return found, reader.notes


class _Said(BaseModel):
    model_config = ConfigDict(extra="ignore")


class _Socket(_Said):
    id: StrictInt | StrictStr
    name: str = ""


_AnySocket = Annotated[_Socket, BeforeValidator(lambda said: said if isinstance(said, dict) else {"id": said})]


class _Entry(_Said):
    name: str = Field(min_length=1)
    type: str = ""
    content: dict[str, Any] = {}
    input_socket: _AnySocket | None = None
    output_sockets: list[_AnySocket] = []


class _Connector(_Said):
    start: Any = None
    end: Any = None


class _Graph(_Said):
    terminal_sockets: list[_Socket]
    states: list[_Entry] = []
    state_machines: list[_Entry] = []
    connectors: list[_Connector] = []


class _Reader:
    def __init__(self, graphs: Mapping[Key, dict[str, Any]], source: str):
        self.graphs, self.source = graphs, source
        self.notes: list[Note] = []

    def container(self, name: str, kind: str, key: Key, depth: int) -> OriginalContainer:
        if depth > _DEEPEST:
            raise BrokenTaskError(f"{self.source}: containers lie in each other more than {_DEEPEST} deep")
        place = "/".join(key)
        graph = self._graph(self.graphs[key], place)
        ends = [each.name for each in graph.terminal_sockets]
        start = ends.index(_START) if _START in ends else 0
        outcomes = [end for number, end in enumerate(ends) if number != start and end]
        made = OriginalContainer(name, kind, outcomes=outcomes, concurrent=kind == CONCURRENT)
        sockets: Sockets = {}
        for number, terminal in enumerate(graph.terminal_sockets):
            role = ("start", "", "") if number == start else ("end", "", ends[number])
            self._socket(sockets, terminal, role, place)
        for entry in graph.states:
            self._child(made, OriginalState(entry.name, entry.type, dict(entry.content)), entry, sockets, place)
        for entry in graph.state_machines:
            inner = self.container(entry.name, entry.type or "StateMachine", self._find(entry.name, key), depth + 1)
            self._child(made, inner, entry, sockets, place)
        self._finish(made, self._connect(made, graph.connectors, sockets, place), place)
        return made

    def _graph(self, data: Mapping[str, Any], place: str) -> _Graph:
        try:
            return _Graph.model_validate(data)
        except ValidationError as error:
            first = error.errors()[0]
            where = "/".join(map(str, first["loc"]))
            raise BrokenTaskError(f"{self.source}: {place}: {where}: {first['msg']}") from None

    def _find(self, name: str, parent: Key) -> Key:
        for key in ((*parent, name), (*parent[:-1], name), (name,)):
            if key in self.graphs:
                return key
        found = [key for key in self.graphs if key[-1:] == (name,)]
        if len(found) != 1:
            raise BrokenTaskError(f"{self.source}: the container {name!r} isn't in the file")
        return found[0]

    def _socket(self, sockets: Sockets, said: _Socket, role: Role, place: str) -> None:
        if sockets.setdefault(said.id, role) != role:
            raise BrokenTaskError(f"{self.source}: {place}: two sockets have the id {said.id!r}; save the task again")

    def _child(
        self, made: OriginalContainer, child: OriginalState, entry: _Entry, sockets: Sockets, place: str
    ) -> None:
        if child.name in made.children:
            raise BrokenTaskError(f"{self.source}: {place}: two states are called {child.name!r}")
        made.children[child.name] = child
        if entry.input_socket is not None:
            self._socket(sockets, entry.input_socket, ("in", child.name, ""), place)
        names = [socket.name for socket in entry.output_sockets]
        names = names if all(names) else _usual(child, len(names))
        if not isinstance(child, OriginalContainer):
            child.outcomes = names
        for socket, outcome in zip(entry.output_sockets, names, strict=True):
            self._socket(sockets, socket, ("out", child.name, outcome), place)

    def _connect(
        self, made: OriginalContainer, connectors: list[_Connector], sockets: Sockets, place: str
    ) -> list[str]:
        """Follow the connectors; return where the container starts."""
        starts = []
        for entry in connectors:
            pair = [role for role in (sockets.get(_id(entry.start)), sockets.get(_id(entry.end))) if role is not None]
            if len(pair) < 2:
                self.notes.append(Note("missing", place, "a connector leads nowhere and was left out"))
                continue
            left, right = sorted(pair, key=lambda role: role[0] not in ("start", "out"))
            if left[0] == "start" and right[0] == "in":
                starts.append(right[1])
            elif left[0] == "out" and right[0] in ("in", "end"):
                target = right[1] if right[0] == "in" else right[2]
                self._lead(made, left[1], left[2], target, right[0] == "end", place)
            else:
                self.notes.append(Note("missing", place, f"a connector joins {left[0]} and {right[0]}: left out"))
        return starts

    def _lead(self, made: OriginalContainer, child: str, outcome: str, target: str, ends: bool, place: str) -> None:
        made.children[child].leads[outcome] = target
        if made.concurrent and ends:
            made.rules.setdefault(target, {}).setdefault(child, []).append(outcome)
        elif made.concurrent:
            text = f"{outcome!r} of {child!r} led to {target!r} in a concurrent container, whose children begin at once"
            self.notes.append(Note("changed", place, text))

    def _finish(self, made: OriginalContainer, starts: list[str], place: str) -> None:
        if not made.children:
            raise BrokenTaskError(f"{self.source}: {place}: the container is empty")
        if not made.outcomes:
            raise BrokenTaskError(f"{self.source}: {place}: the container has no outcomes")
        made.initial, made.default = (starts or list(made.children))[0], made.outcomes[-1]
        if made.concurrent:
            made.rules.pop(made.default, None)
            text = f"which outcome was the default isn't in such a file; {made.default!r}, the last one, is taken"
            self.notes.append(Note("changed", place, text))
        elif len(starts) != 1:
            text = f"Start leads to {starts or 'nothing'}; it begins with {made.initial!r}"
            self.notes.append(Note("missing", place, text))


def _usual(child: OriginalState, count: int) -> list[str]:
    """Return the outcomes of a state whose file only counts them."""
    if isinstance(child, OriginalContainer) and len(child.outcomes) == count:
        return child.outcomes
    if child.type in OUTCOMES and count == len(OUTCOMES[child.type]):
        return OUTCOMES[child.type]
    if count == 2:
        return ["success", "failure"]
    return [*(str(number) for number in range(count - 1)), "state_failure"]


def _id(said: Any) -> int | str | None:
    found = said.get("id") if isinstance(said, dict) else said
    return found if isinstance(found, int | str) else None
