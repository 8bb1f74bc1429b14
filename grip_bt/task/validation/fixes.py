"""Fixes as commands: what an editor, or a person in a hurry, can do about an issue with one press.

A fix is offered only where it can be carried out, and none is a guess about what a task is for: names are corrected to
the nearest one, what is never used goes, what leads nowhere leads to an end of the same meaning.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import islice

from grip_bt.base.errors import EditError
from grip_bt.base.issue import Issue
from grip_bt.task import Leaf, Task
from grip_bt.task.canonical import file_data
from grip_bt.task.catalog import Catalog, InputPort, OutputPort, is_assignable, parse_type
from grip_bt.task.edit import AnyCommand, Connect, Declare, Group, Remove, Set, Undeclare, Unset, apply

from .analysis import PlacedNode, TaskAnalysis, VariableDeclaration
from .parts import known_messages, names_for

MOST = 4
"""Fixes that are offered for one issue at most."""


@dataclass(frozen=True)
class Fix:
    """A way to mend an issue."""

    title: str
    command: AnyCommand


class Fixer:
    """Finds fixes for the issues of one task."""

    def __init__(self, task: Task, catalog: Catalog):
        self._analysis = TaskAnalysis(task, catalog)
        self._nodes = {placed.path: placed for placed in self._analysis.nodes}

    def fixes(self, issue: Issue) -> tuple[Fix, ...]:
        """Return what can be done about an issue, the most likely first; often nothing."""
        placed = self._nodes.get(issue.path)
        found = (fix for find in _FINDERS.get(issue.code, ()) for fix in find(self._analysis, placed, issue))
        return tuple(islice((Fix(title, command) for title, command in found if self._works(command)), MOST))

    def _works(self, command: AnyCommand) -> bool:
        try:
            apply(self._analysis.task, command)
        except EditError:
            return False
        return True


_Found = Iterator[tuple[str, AnyCommand]]


def _near(name: str, allowed: Iterable[str]) -> list[str]:
    return get_close_matches(name, list(allowed), n=2, cutoff=0.6)


def _corrected(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    if placed is None:
        return
    key = tuple(map(str, issue.key))
    said: object = file_data(placed.node)
    for step in key:
        said = said.get(step) if isinstance(said, dict) else None
    allowed = _allowed(analysis, placed, issue) if isinstance(said, str) else ()
    near = _near(str(said), allowed)
    if issue.code == "unknown-child":
        near += [name for name in allowed if name not in near][:1]
    if issue.code in _OF_PARTS and len(allowed) == 1:
        near = list(allowed)
    for name in near:
        yield f"Use {name}", Set(path=issue.path, key=key, value=name)


def _allowed(analysis: TaskAnalysis, placed: PlacedNode, issue: Issue) -> Sequence[str]:
    if issue.code == "unknown-node":
        return analysis.catalog.ids()
    if issue.code == "unknown-target":
        if issue.key[0] == "exits":
            return list(placed.outcomes)
        above = placed.parent
        return [*above.children, *above.outcomes] if above is not None else list(analysis.task.outcomes)
    if issue.code == "unknown-child":
        return list(placed.children) if issue.key == ("initial",) else ()
    if issue.code == "unknown-message" and isinstance(placed.node, Leaf):
        return sorted((known_messages(analysis) or {}).get(str(placed.node.with_.get("store")), ()))
    return list(names_for(analysis.catalog.parts(), placed, str(issue.key[-1]))) if len(issue.key) == 2 else ()


def _removed(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    if issue.key in (("on",), ("default",)) or len(issue.key) == 2 and issue.key[0] in _REMOVABLE:
        key = tuple(map(str, issue.key))
        verb = "Share the outer" if issue.code == "shadowed-variable" else "Remove"
        yield f"{verb} {key[-1]}", Unset(path=issue.path, key=key)


def _renamed(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    if placed is None or not isinstance(placed.node, Leaf) or placed.manifest is None:
        return
    side, name = str(issue.key[0]), str(issue.key[1])
    manifest, given = placed.manifest, file_data(placed.node)[side]
    names: dict[str, Iterable[str]] = {
        "with": manifest.parameters,
        "in": manifest.inputs,
        "out": manifest.outputs,
        "meaning": manifest.outcomes,
    }
    drop = Unset(path=issue.path, key=(side, name))
    for other in _near(name, names[side]):
        if other not in given:
            put = Set(path=issue.path, key=(side, other), value=given[name])
            yield f"Rename to {other}", Group(title=f"rename {name} to {other}", commands=(put, drop))
    yield f"Remove {name}", drop


def _ports(placed: PlacedNode | None, issue: Issue) -> tuple[PlacedNode, str, InputPort | OutputPort] | None:
    if placed is None or placed.manifest is None or len(issue.key) != 2 or issue.key[0] not in ("in", "out"):
        return None
    side, name = issue.key
    ports = placed.manifest.inputs if side == "in" else placed.manifest.outputs
    port = ports.get(str(name))
    return None if port is None else (placed, str(name), port)


def _fits(declared: VariableDeclaration, port: InputPort | OutputPort) -> bool:
    if declared.type is None:
        return False
    wanted = parse_type(port.type)
    return is_assignable(declared.type, wanted) if isinstance(port, InputPort) else is_assignable(wanted, declared.type)


def _binding(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    """Bind a port to a variable that is there and fits; else declare one for it."""
    found = _ports(placed, issue)
    if found is None:
        return
    placed, name, port = found
    assert isinstance(placed.node, Leaf)
    side = "in" if isinstance(port, InputPort) else "out"
    said = (placed.node.in_ if side == "in" else placed.node.out).get(name, "")
    fitting = [variable for variable, declared in placed.scope.items() if _fits(declared, port)]
    likely = [v for v in (*_near(said, fitting), name, *reversed(fitting)) if v in fitting]
    for variable in list(dict.fromkeys(likely))[: MOST - 1]:
        yield f"Bind {name} to {variable}", Set(path=issue.path, key=(side, name), value=variable)
    new = said or name
    if new not in placed.scope:
        bind = Set(path=issue.path, key=(side, name), value=new)
        commands = (Declare(path="", name=new, variable=port.type), *(() if said == new else (bind,)))
        yield f"Declare {new}: {port.type}", Group(title=f"declare {new}", commands=commands)
    if said:
        yield f"Unbind {name}", Unset(path=issue.path, key=(side, name))


def _unused_variable(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    name = str(issue.key[-1])
    writers = [
        Unset(path=other.path, key=("out", port))
        for other in analysis.nodes
        if isinstance(other.node, Leaf) and name in other.scope and other.scope[name].owner == issue.path
        for port, variable in other.node.out.items()
        if variable == name
    ]
    gone = Undeclare(path=issue.path, name=name)
    yield f"Remove {name}", Group(title=f"remove {name}", commands=(*writers, gone)) if writers else gone


def _missing_target(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    """Lead an outcome to an end of the same meaning; a success in a machine to the next sibling, too."""
    if placed is None:
        return
    outcome = str(issue.key[-1])
    meaning = placed.outcomes.get(outcome)
    ends = analysis.task.outcomes if placed.parent is None else placed.parent.outcomes
    alike = [end for end, means in ends.items() if means == meaning]
    siblings = list(placed.parent.children) if placed.parent is not None else []
    after = siblings[siblings.index(placed.name) + 1 :][:1] if placed.name in siblings else []
    for target in [*(after if meaning == "success" else []), *alike]:
        yield f"Connect {outcome} to {target}", Connect(path=issue.path, outcome=outcome, target=target)


def _node_goes(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    yield f"Remove {placed.name if placed else issue.path}", Remove(path=issue.path)


def _declared_order(analysis: TaskAnalysis, placed: PlacedNode | None, issue: Issue) -> _Found:
    yield "Tick in declared order", Set(path=issue.path, key=("order",), value="declared")


_REMOVABLE = ("on", "exits", "cases", "meaning", "outcomes", "data")
"""Keys of which an entry may go."""
_OF_PARTS = ("unknown-arm", "unknown-hand", "unknown-state", "unknown-link")
_FINDERS: dict[str, tuple[Callable[[TaskAnalysis, PlacedNode | None, Issue], _Found], ...]] = {
    **dict.fromkeys(("unknown-node", "unknown-message", *_OF_PARTS), (_corrected,)),
    **dict.fromkeys(("unknown-target", "unknown-child"), (_corrected, _removed)),
    **dict.fromkeys(("unknown-outcome", "unknown-code", "impossible-outcome"), (_removed,)),
    **dict.fromkeys(("shadowed-variable", "misplaced-on", "unused-outcome"), (_removed,)),
    **dict.fromkeys(("unknown-parameter", "unknown-input", "unknown-output"), (_renamed,)),
    **dict.fromkeys(("missing-input", "undeclared-variable", "wrong-variable-type"), (_binding,)),
    **dict.fromkeys(("unreachable-node", "empty-container"), (_node_goes,)),
    **dict.fromkeys(("parallel-writes", "parallel-read-write"), (_declared_order,)),
    "never-read": (_unused_variable,),
    "missing-target": (_missing_target,),
}
