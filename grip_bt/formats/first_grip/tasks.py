"""Tasks of the first GRIP as they were meant: graphs of its editor in `.ini` files, and its older text form."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, StrictInt, StrictStr, ValidationError

from grip_bt.base.errors import GripError
from grip_bt.formats.imported import Issues
from grip_bt.formats.names import free, key_of, node_name
from grip_bt.task.model import Meaning

from .settings import Key, Refused


@dataclass
class GripState:
    """One state; its type is a class, a component, a sensor or a state of the user's.

    The first of its outcomes is the good one, the last the bad one; each leads to a state or outcome of the container.
    """

    name: str
    type: str
    slots: dict[str, Any] = field(default_factory=dict)
    outcomes: list[str] = field(default_factory=list)
    leads: dict[str, str] = field(default_factory=dict)


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


_BAD = ("fail", "abort", "error", "none", "preempt")


def name_of(label: str, taken: Collection[str] = ()) -> str:
    """Return a label as a task may spell it, none of those that are taken."""
    return free(node_name(label), taken)


def outcome_meanings(outcomes: Sequence[str]) -> dict[str, Meaning]:
    """Return what outcomes mean: the first is good, the last of several bad, others by their names."""
    found: dict[str, Meaning] = {}
    for number, outcome in enumerate(outcomes):
        bad = any(word in outcome.lower() for word in _BAD)
        last = number == len(outcomes) - 1
        found[outcome] = "success" if number == 0 or not (bad or last) else "failure"
    return found


def is_hand(group: str) -> bool:
    """Tell whether a group of joints is a hand, by its name."""
    return any(word in group.lower() for word in ("hand", "gripper", "finger")) and "arm" not in group.lower()


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


def graph_task(settings: Mapping[Key, object], source: str, issues: Issues) -> GripContainer:
    """Return the task that a file of settings holds; what isn't as it was is added to the issues.

    Raises:
        BrokenTaskError: there is none in it, or it is broken.
    """
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
        if depth > _DEEPEST:
            raise BrokenTaskError(f"{self.source}: containers lie in each other more than {_DEEPEST} deep")
        place = "/".join(key)
        try:
            graph = _Graph.model_validate(self.graphs[key])
        except ValidationError as error:
            first = error.errors()[0]
            where = "/".join(map(str, first["loc"]))
            raise BrokenTaskError(f"{self.source}: {place}: {where}: {first['msg']}") from None
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
        if not made.children:
            raise BrokenTaskError(f"{self.source}: {place}: the container is empty")
        if not made.outcomes:
            raise BrokenTaskError(f"{self.source}: {place}: the container has no outcomes")
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
    if isinstance(child, GripContainer) and len(child.outcomes) == count:
        return child.outcomes
    if child.type in OUTCOMES and count == len(OUTCOMES[child.type]):
        return OUTCOMES[child.type]
    if count == 2:
        return ["success", "failure"]
    return [*(str(number) for number in range(count - 1)), "state_failure"]


def _id(said: object) -> int | str | None:
    found = said.get("id") if isinstance(said, dict) else said
    return found if isinstance(found, int | str) else None


_CONTAINERS = {"state_machine": False, "concurrent_state_machine": True, "sm_base": False}
_NAMED = ("ComputePlan", "Move", "Counter", "Select", "WaitFor", "ExecuteTrajectory", "AllowCollisions")
_TYPES = {"plan": "ComputePlan", **{key_of(name): name for name in (*_NAMED, "ReinitialiseManagers")}}


def text_task(data: object, source: str) -> GripContainer:
    """Return the task that a nested dictionary holds.

    Raises:
        BrokenTaskError: it holds none, or is broken.
    """
    if not isinstance(data, Mapping) or "states" not in data:
        raise BrokenTaskError(f"{source}: there is no task in it: `name`, `outcomes` and `states` are expected")
    return _container(str(data.get("name") or "task"), data, source, 0)


def _container(name: str, data: Mapping[str, Any], place: str, depth: int) -> GripContainer:
    if depth > _DEEPEST:
        raise BrokenTaskError(f"{place}: containers lie in each other more than {_DEEPEST} deep")
    outcomes = data.get("outcomes") or list(data.get("transitions") or {}) or ["success", "fail"]
    if not isinstance(outcomes, list) or not all(isinstance(each, str | int) for each in outcomes):
        raise BrokenTaskError(f"{place}: `outcomes` is a list of names")
    made = GripContainer(name, str(data.get("source", "")), outcomes=[str(each) for each in outcomes])
    made.concurrent = _CONTAINERS.get(made.type, False)
    states = data.get("states")
    if not isinstance(states, list) or not states:
        raise BrokenTaskError(f"{place}: `states` is a list of states and not empty")
    for entry in states:
        if not isinstance(entry, Mapping) or len(entry) != 1:
            raise BrokenTaskError(f"{place}: a state is `NAME: {{source: ..., ...}}`, not {str(entry)[:60]}")
        ((label, said),) = entry.items()
        inside = f"{place}/{label}"
        if not isinstance(said, Mapping):
            raise BrokenTaskError(f"{inside}: a mapping with `source` is expected")
        if str(label) in made.children:
            raise BrokenTaskError(f"{inside}: two states have this name")
        made.children[str(label)] = _child(str(label), said, inside, depth)
    made.initial = str(data.get("initial") or next(iter(made.children)))
    if made.concurrent:
        made.default = str(data.get("default_outcome") or made.outcomes[-1])
        said = data.get("outcome_map") or {}
        if not isinstance(said, Mapping) or not all(isinstance(when, Mapping) for when in said.values()):
            raise BrokenTaskError(f"{place}: `outcome_map` is outcome -> state -> outcome")
        made.rules = {str(o): {str(child): [str(end)] for child, end in when.items()} for o, when in said.items()}
    return made


def _child(label: str, said: Mapping[str, Any], place: str, depth: int) -> GripState:
    leads = said.get("transitions") or {}
    if not isinstance(leads, Mapping):
        raise BrokenTaskError(f"{place}: `transitions` is a mapping from outcomes to states")
    source = str(said.get("source", ""))
    if source in _CONTAINERS or "states" in said:
        made: GripState = _container(label, said, place, depth + 1)
    else:
        kind = _TYPES.get(source, source)
        rest = {str(k): v for k, v in said.items() if k not in ("source", "transitions", "outcomes")}
        outcomes = said.get("outcomes") or list(leads) or OUTCOMES.get(kind, ["success", "failure"])
        made = GripState(label, kind, rest, [str(each) for each in outcomes])
    made.leads = {str(outcome): str(target) for outcome, target in leads.items()}
    return made
