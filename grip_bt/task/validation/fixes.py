"""Fixes as commands: what an editor, or a person in a hurry, can do about an issue with one press.

A fix is offered only where it can be carried out, and none is a guess about what a task is for: names are corrected to
the nearest one, what is never used goes, what leads nowhere leads to an end of the same meaning.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches

from grip_bt.base.errors import EditError
from grip_bt.base.issue import Issue
from grip_bt.task import Leaf, StateMachine, Task
from grip_bt.task.catalog import Catalog, InputPort, OutputPort, is_assignable, parse_type
from grip_bt.task.edit import (
    AnyCommand,
    Connect,
    Declare,
    Disconnect,
    Group,
    Remove,
    Set,
    Undeclare,
    Unset,
    apply,
)

from .parts import known_messages, names_for
from .survey import Declared, Spot, Survey

MOST = 4
"""Fixes that are offered for one issue at most."""


@dataclass(frozen=True)
class Fix:
    """A way to mend an issue.

    Attributes:
        title: what it does, in a few words.
        command: what to apply.
    """

    title: str
    command: AnyCommand


class Fixer:
    """Finds fixes for the issues of one task.

    Args:
        task: the task that was validated.
        catalog: the nodes that exist.
    """

    def __init__(self, task: Task, catalog: Catalog):
        self._survey = Survey(task, catalog)
        self._spots = {spot.path: spot for spot in self._survey.spots}

    def fixes(self, issue: Issue) -> tuple[Fix, ...]:
        """Return what can be done about an issue, the most likely first; often nothing."""
        find = _FINDERS.get(issue.code)
        if find is None:
            return ()
        found: list[Fix] = []
        for title, command in find(self._survey, self._spots.get(issue.path), issue):
            if len(found) < MOST and self._works(command):
                found.append(Fix(title, command))
        return tuple(found)

    def _works(self, command: AnyCommand) -> bool:
        try:
            apply(self._survey.task, command)
        except EditError:
            return False
        return True


_Found = Iterator[tuple[str, AnyCommand]]


def _near(name: str, allowed: Iterable[str]) -> list[str]:
    return get_close_matches(name, list(allowed), n=2, cutoff=0.6)


def _node(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    if spot is not None and isinstance(spot.node, Leaf):
        for id in _near(spot.node.node, survey.catalog.ids())[:1]:
            yield f"Use {id}", Set(path=issue.path, key=("node",), value=id)


def _unknown_key(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Correct a parameter, a port or a meaning to the nearest one, or take it out."""
    side, name = str(issue.key[0]), str(issue.key[1])
    if spot is None or not isinstance(spot.node, Leaf) or spot.manifest is None:
        return
    face: dict[str, Iterable[str]] = {
        "with": spot.manifest.parameters,
        "in": spot.manifest.inputs,
        "out": spot.manifest.outputs,
    }
    given = {"with": spot.node.with_, "in": spot.node.in_, "out": spot.node.out, "meaning": spot.node.meaning}[side]
    drop = Unset(path=issue.path, key=(side, name))
    for other in _near(name, face.get(side, spot.manifest.outcomes)):
        if other not in given:
            put = Set(path=issue.path, key=(side, other), value=given[name])
            yield f"Call it {other}", Group(title=f"{name} is called {other}", commands=(put, drop))
    yield f"Remove {name}", drop


def _ports(spot: Spot | None, issue: Issue) -> tuple[Spot, str, InputPort | OutputPort] | None:
    if spot is None or spot.manifest is None or len(issue.key) != 2 or issue.key[0] not in ("in", "out"):
        return None
    side, name = issue.key
    ports = spot.manifest.inputs if side == "in" else spot.manifest.outputs
    port = ports.get(str(name))
    return None if port is None else (spot, str(name), port)


def _fits(declared: Declared, port: InputPort | OutputPort) -> bool:
    if declared.type is None:
        return False
    wanted = parse_type(port.type)
    return is_assignable(declared.type, wanted) if isinstance(port, InputPort) else is_assignable(wanted, declared.type)


def _binding(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Bind a port to a variable that is there and fits; else declare one for it."""
    found = _ports(spot, issue)
    if found is None:
        return
    spot, name, port = found
    assert isinstance(spot.node, Leaf)
    side = "in" if isinstance(port, InputPort) else "out"
    said = (spot.node.in_ if side == "in" else spot.node.out).get(name, "")
    fitting = [variable for variable, declared in spot.scope.items() if _fits(declared, port)]
    likely = [v for v in (*_near(said, fitting), name, *reversed(fitting)) if v in fitting]
    for variable in list(dict.fromkeys(likely))[: MOST - 1]:
        yield f"Bind {name} to {variable}", Set(path=issue.path, key=(side, name), value=variable)
    new = said or name
    if new not in spot.scope:
        bind = Set(path=issue.path, key=(side, name), value=new)
        commands = (Declare(path="", name=new, variable=port.type), *(() if said == new else (bind,)))
        yield f"Declare {new}: {port.type}", Group(title=f"declare {new}", commands=commands)
    if said:
        yield f"Unbind {name}", Unset(path=issue.path, key=(side, name))


def _message(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Correct the name of a message to the nearest ones of its store."""
    if spot is not None and isinstance(spot.node, Leaf):
        there = (known_messages(survey) or {}).get(str(spot.node.with_.get("store")), ())
        for name in _near(str(spot.node.with_.get("name")), sorted(there)):
            yield f"Read {name}", Set(path=issue.path, key=("with", "name"), value=name)


def _named_part(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Correct the name of an arm, a hand, a state and so on to the nearest ones, or to the only one."""
    if spot is None or not isinstance(spot.node, Leaf) or len(issue.key) != 2:
        return
    name = str(issue.key[1])
    known, said = names_for(survey.catalog.equipment(), spot, name), spot.node.with_.get(name)
    if isinstance(said, str):
        for other in _near(said, known) or (list(known) if len(known) == 1 else []):
            yield f"Write {other}", Set(path=issue.path, key=("with", name), value=other)


def _unused_variable(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Take out a variable that nobody reads, with the bindings of those who write it."""
    name = str(issue.key[-1])
    writers = [
        Unset(path=other.path, key=("out", port))
        for other in survey.spots
        if isinstance(other.node, Leaf) and name in other.scope and other.scope[name].owner == issue.path
        for port, variable in other.node.out.items()
        if variable == name
    ]
    gone = Undeclare(path=issue.path, name=name)
    yield f"Remove {name}", Group(title=f"remove {name}", commands=(*writers, gone)) if writers else gone


def _shadow(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    if issue.key[0] == "data":
        yield f"Share the outer {issue.key[1]}", Unset(path=issue.path, key=("data", str(issue.key[1])))


def _edge(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Correct where an end leads to the nearest target, or take the edge out."""
    if spot is None or len(issue.key) != 2:
        return
    field, key = str(issue.key[0]), str(issue.key[1])
    if field == "exits":
        allowed, said = list(spot.outcomes), getattr(spot.node, "exits", {}).get(key, "")
    else:
        allowed, said = _ends(survey, spot), spot.node.on.get(key, "")
    if issue.code == "unknown-target":
        for target in _near(said, allowed):
            yield f"Lead to {target}", Set(path=issue.path, key=(field, key), value=target)
    yield f"Remove {key}", Unset(path=issue.path, key=(field, key))


def _ends(survey: Survey, spot: Spot) -> list[str]:
    if spot.parent is None:
        return list(survey.task.outcomes)
    return [*spot.parent.children, *spot.parent.outcomes]


def _missing_target(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    """Lead an outcome to an end of the same meaning; a success in a machine to the next sibling, too."""
    if spot is None:
        return
    outcome = str(issue.key[-1])
    meaning = spot.outcomes.get(outcome)
    ends = survey.task.outcomes if spot.parent is None else spot.parent.outcomes
    alike = [end for end, means in ends.items() if means == meaning]
    siblings = list(spot.parent.children) if spot.parent is not None else []
    after = siblings[siblings.index(spot.name) + 1 :][:1] if spot.name in siblings else []
    for target in [*(after if meaning == "success" else []), *alike]:
        yield f"Lead {outcome} to {target}", Connect(path=issue.path, outcome=outcome, target=target)


def _child(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    if spot is None:
        return
    if issue.key == ("initial",) and isinstance(spot.node, StateMachine):
        for name in dict.fromkeys((*_near(spot.node.initial, spot.children), *list(spot.children)[:1])):
            yield f"Begin with {name}", Set(path=issue.path, key=("initial",), value=name)
    elif issue.key[0] in ("exits", "cases") and len(issue.key) == 2:
        yield f"Remove {issue.key[1]}", Unset(path=issue.path, key=(str(issue.key[0]), str(issue.key[1])))
    elif issue.key == ("default",):
        yield "Remove default", Unset(path=issue.path, key=("default",))


def _node_goes(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    yield f"Remove {spot.name if spot else issue.path}", Remove(path=issue.path)


def _misplaced(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    yield "Remove on", Unset(path=issue.path, key=("on",))


def _outcome_goes(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    name = str(issue.key[-1])
    yield f"Remove {name}", Unset(path=issue.path, key=("outcomes", name))


def _impossible(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    if len(issue.key) == 2 and issue.key[0] == "exits":
        child, _, label = str(issue.key[1]).partition(".")
        path = child if issue.path == "/" else f"{issue.path}/{child}"
        yield f"Remove the exit {issue.key[1]}", Disconnect(path=path, outcome=label)


def _declared_order(survey: Survey, spot: Spot | None, issue: Issue) -> _Found:
    yield "Tick in declared order", Set(path=issue.path, key=("order",), value="declared")


_FINDERS: dict[str, Callable[[Survey, Spot | None, Issue], _Found]] = {
    "unknown-node": _node,
    "unknown-parameter": _unknown_key,
    "unknown-input": _unknown_key,
    "unknown-output": _unknown_key,
    "missing-input": _binding,
    "undeclared-variable": _binding,
    "wrong-variable-type": _binding,
    "never-read": _unused_variable,
    "shadowed-variable": _shadow,
    "unknown-outcome": _edge,
    "unknown-code": _edge,
    "unknown-message": _message,
    **dict.fromkeys(("unknown-arm", "unknown-hand", "unknown-state", "unknown-link"), _named_part),
    "unknown-target": _edge,
    "missing-target": _missing_target,
    "unknown-child": _child,
    "impossible-outcome": _impossible,
    "unreachable-node": _node_goes,
    "empty-container": _node_goes,
    "misplaced-on": _misplaced,
    "unused-outcome": _outcome_goes,
    "parallel-writes": _declared_order,
    "parallel-read-write": _declared_order,
}
