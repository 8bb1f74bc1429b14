"""Every way that a container can go: each question of its kind is answered with every answer in turn."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, NoReturn

from grip_bt.base.types import Value

from .kinds.base import ChildEnds, End, Ended, Kind, Next, Run, State, Stay, Step
from .parts import Case, Edges

LIMIT = 100_000
"""Steps of one exploration; beyond them a kind is taken to be able to do everything."""


class TooManyError(Exception):
    """The kind has too many states."""


class NoWayError(Exception):
    """A document names a child that isn't there; a rule of the validation says so."""


class _Unknown:
    """A value of which nothing is known: a kind that compares it has looked at data."""

    def __add__(self, other: object) -> _Unknown:
        return self

    __sub__ = __radd__ = __rsub__ = __add__

    def __format__(self, spec: str) -> str:
        return "?"

    def __repr__(self) -> str:
        return "?"

    def _refuse(self, *_: object) -> NoReturn:
        raise TypeError("a kind asks about data, and never looks at it")

    __eq__ = __lt__ = __le__ = __gt__ = __ge__ = __bool__ = __len__ = _refuse
    __hash__ = object.__hash__


UNKNOWN: State = _Unknown()
START = ("start",)


class Labels:
    """With what the children can end, and where labels lead.

    Args:
        ends: child -> its possible outcomes and their meanings, in the order of the children.
    """

    def __init__(self, ends: Mapping[str, Sequence[tuple[str, str]]], exits: Edges, edges: Edges):
        self.ends, self.exits, self.edges = ends, exits, edges
        self.names = tuple(ends)
        self.ways: list[Way] | None = None
        self.answers: frozenset[str] | None = None
        self._codes: dict[tuple[str, str], dict[str, None]] = {}
        for (child, outcome, code), _ in (*exits, *edges):
            if code is not None:
                self._codes.setdefault((child, outcome), {})[code] = None

    @cached_property
    def all(self) -> ChildEnds:
        return [[(end, self.exit(end)) for end in self.of(name)] for name in self.names]

    def exit(self, end: Ended) -> str | None:
        return self.exits.target(end.child, end.outcome, end.code)

    def of(self, child: str) -> Iterator[Ended]:
        """Yield every end of a child that may matter: each outcome, and each with each code that an edge names."""
        for outcome, meaning in self.ends[child]:
            yield Ended(child, outcome, meaning)
            for code in self._codes.get((child, outcome), ()):
                yield Ended(child, outcome, meaning, code)


class Oracle:
    """Answers a kind's questions by the given answers, and after them by the first that there is."""

    def __init__(self, labels: Labels, answers: tuple[int, ...] = (), ends: Sequence[Ended | None] = ()):
        self.labels, self.answers, self.ends = labels, answers, ends
        self.names: Sequence[str] = labels.names
        self.asked: list[tuple[str, ...]] = []
        self.trail: list[int] = []
        self.reads: list[str] = []
        self.puts: list[str] = []
        self.kept: State = UNKNOWN

    def _ask(self, *answers: str) -> int:
        at = len(self.trail)
        self.asked.append(answers)
        self.trail.append(self.answers[at] if at < len(self.answers) else 0)
        return self.trail[-1]

    @property
    def said(self) -> tuple[str, ...]:
        return tuple(answers[i] for answers, i in zip(self.asked, self.trail, strict=True))

    def at(self, name: str) -> int:
        if name not in self.names:
            raise NoWayError
        return self.names.index(name)

    def now(self, *_: object, **__: object) -> State:
        return UNKNOWN

    deadline = up = value = now

    def passed(self, at: object) -> bool:
        return bool(self._ask("before", "after"))

    def reached(self, count: object, limit: int) -> bool:
        return bool(self._ask("again", "enough"))

    def pick(self, count: object, size: int) -> int:
        return self._ask(*(f"turn {i + 1}" for i in range(size)))

    def holds(self, key: str) -> bool:
        self.reads.append(key)
        return not self._ask("true", "false")

    def match(self, key: str, literals: Sequence[tuple[str, Case]], default: str) -> str:
        self.reads.append(key)
        answers = (*(json.dumps(literal) for _, literal in literals), "else")
        return (*(child for child, _ in literals), default)[self._ask(*answers)]

    def items(self, key: str) -> State:
        self.reads.append(key)
        return UNKNOWN

    def empty(self, left: State) -> bool:
        return bool(self._ask("next", "none"))

    def take(self, left: State) -> tuple[Value, State]:
        return UNKNOWN, UNKNOWN

    def put(self, key: str, value: Value) -> None:
        self.puts.append(key)

    def exit(self, end: Ended) -> str | None:
        return self.labels.exit(end)

    def edge(self, end: Ended) -> str:
        """Return where the document leads; nowhere is no way."""
        target = self.labels.edges.target(end.child, end.outcome, end.code)
        if target is None:
            raise NoWayError
        return target

    def ask(self, text: str) -> None:
        """Do nothing."""


class Way(NamedTuple):
    """One step of the graph.

    Attributes:
        child: who ends, None where nobody does.
        step: what the kind says; None where a child goes on running.
        to: the vertex to which it leads, None for an end.
    """

    at: State
    child: int | None
    end: Ended | None
    answers: tuple[str, ...]
    reads: tuple[str, ...]
    puts: tuple[str, ...]
    step: Step | None
    to: State


def answered(
    labels: Labels, call: Callable[[Oracle], Step], ends: Sequence[Ended | None] = ()
) -> Iterator[tuple[Step, Oracle]]:
    """Yield what `call` returns for every combination of answers."""
    todo: deque[tuple[int, ...]] = deque([()])
    while todo:
        oracle = Oracle(labels, todo.popleft(), ends)
        try:
            step = call(oracle)
        except NoWayError:
            step = None
        for at in range(len(oracle.answers), len(oracle.trail)):
            todo.extend((*oracle.trail[:at], other) for other in range(1, len(oracle.asked[at])))
        if step is not None:
            yield step, oracle


def explore(kind: Kind, labels: Labels) -> Iterator[Way]:
    """Yield every way; a vertex is START, or (running, to be ticked yet in this tick, state, ends).

    A child that was ticked may have ended or go on running; when nobody is left to be ticked the kind settles.

    Raises:
        TooManyError: there are too many.
    """
    seen, todo, steps = {START}, deque([START]), 0
    while todo:
        at = todo.popleft()
        for way in _ways(kind, labels, at):
            steps += 1
            if steps > LIMIT:
                raise TooManyError
            yield way
            if way.to is not None and way.to not in seen:
                seen.add(way.to)
                todo.append(way.to)


def _ways(kind: Kind, labels: Labels, at: Any) -> Iterator[Way]:
    if at == START:
        yield from _taken(kind, labels, at, lambda q: kind.begin(None, q))
        return
    running, due, state, ends = at
    if type(state) is Next:
        yield from _taken(kind, labels, at, lambda q: kind.begin(state.state, q))
    elif due:
        child, rest = due[0], due[1:]
        left = tuple(i for i in running if i != child)
        for end in labels.of(labels.names[child]):
            taken = None if kind.late_exits else labels.exit(end)
            if taken is not None:
                yield Way(at, child, end, ("exit",), (), (), End(taken), None)
                continue
            now = (*ends[:child], end, *ends[child + 1 :]) if kind.concurrent else ()

            def ended(q: Oracle, end: Ended = end) -> Step:
                return kind.ended(state, child, end, q)

            yield from _taken(kind, labels, at, ended, child, end, left, rest, now)
        if rest or kind.settles or kind.reactive:  # it goes on running
            yield Way(at, None, None, (), (), (), None, (running, rest, state, ends))
    elif kind.settles:
        for step, oracle in answered(labels, lambda q: kind.settle(state, q), ends):
            yield from _further(kind, labels, at, step, oracle)
    else:
        yield from _further(kind, labels, at, Stay(state), Oracle(labels))


def _further(kind: Kind, labels: Labels, at: Any, step: Step, oracle: Oracle) -> Iterator[Way]:
    running, _, _, ends = at
    if type(step) is End:
        yield Way(at, None, None, oracle.said, tuple(oracle.reads), (), step, None)
        return
    assert type(step) is Stay, "a kind settles by staying or by an end"
    if kind.reactive:
        go_on = Run(running, step.state)
        yield from _taken(
            kind, labels, at, lambda q: kind.again(step.state, running, q) or go_on, None, None, running, (), ends
        )
    else:
        yield Way(at, None, None, oracle.said, (), (), step, (running, running, step.state, ends))


def _taken(
    kind: Kind,
    labels: Labels,
    at: Any,
    call: Callable[[Oracle], Step],
    child: int | None = None,
    end: Ended | None = None,
    running: tuple[int, ...] = (),
    rest: tuple[int, ...] = (),
    ends: tuple[Ended | None, ...] = (),
) -> Iterator[Way]:
    for step, oracle in answered(labels, call, ends):
        to: Any = None
        if type(step) is Run:
            again = set(step.children) if kind.concurrent else ()
            kept = tuple(None if i in again else e for i, e in enumerate(ends or (None,) * len(again)))
            to = (step.children, step.children, step.state, kept)
        elif type(step) is Next:
            to = ((), (), step, ())
        elif type(step) is Stay:
            to = (running, rest, step.state, ends)
        yield Way(at, child, end, oracle.said, tuple(oracle.reads), tuple(oracle.puts), step, to)


def graph(kind: Kind, labels: Labels) -> list[Way]:
    """Return every way of `explore`, found once; TooManyError where there are too many."""
    if labels.ways is None:
        labels.ways = list(explore(kind, labels))
    return labels.ways


def answers(kind: Kind, labels: Labels) -> frozenset[str]:
    """Return what the kind is ever told when it asks, found once."""
    if labels.answers is None:
        labels.answers = frozenset(answer for way in graph(kind, labels) for answer in way.answers)
    return labels.answers
