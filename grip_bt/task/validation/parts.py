"""Names that tasks teach to arms and hands while they run: of this task, of files that it runs, of others."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from typing import Literal

from grip_bt.base.errors import SubtaskError, listing, nearest
from grip_bt.task import Foreign, Leaf, Subtask, Task, walk
from grip_bt.task.catalog import AllowedImports
from grip_bt.task.catalog.project_parts import (
    MISSING_PACKAGE,
    NO_CONTROLLER,
    UNFIT_PROJECT,
    PartNames,
    Problem,
    ProjectParts,
    missing_type,
)
from grip_bt.task.validation.analysis import Key, PlacedNode, TaskAnalysis
from grip_bt.task.validation.codes import suggestion

_TEACHERS = {"arm/teach": "arm", "hand/teach": "hand"}
"""Nodes by which a task gives names, and to what."""
_NOT_YET = "not-taught-yet"
BY_TAUGHT, BY_STATE = "go there by `arm/move_to_taught`", "go there by `arm/move_to`"


_TaughtName = tuple[str, str, str]
"""`arm` or `hand`, which of them, and a name that a task gives to where it is."""


class TaughtNames:
    """What tasks of a project teach."""

    def __init__(self, analysis: TaskAnalysis, parts: ProjectParts):
        self._analysis, self._files = analysis, analysis.catalog.tasks
        self._parts = {"arm": parts.arms or {}, "hand": parts.hands or {}}

    def problem(self, kind: str, part: str, name: str) -> Problem | None | Literal[False]:
        """Return what is to be said of a name that isn't there yet.

        Args:
            kind: `state` (looked up before a run), `posture` or `taught` (looked up when they are reached).

        Returns:
            What is wrong; None where the task gives the name itself, in time; False where nothing is known of it.
        """
        wanted = ("hand" if kind == "posture" else "arm", part, name)
        if wanted in self._own:
            said = f"{name!r} is taught only while this task runs, and named states are looked up before it begins"
            fix = f"{BY_TAUGHT}, or teach it by another task first"
            return Problem(_NOT_YET, said, fix) if kind == "state" else None
        files = [file for file, taught_names in self._others.items() if wanted in taught_names]
        if not files:
            return False
        verb = "teaches" if len(files) == 1 else "teach"
        said = f"{name!r} hasn't been taught to {part} yet; {listing(files)} {verb} it"
        return Problem(_NOT_YET, said, f"run {files[0]} first")

    @cached_property
    def _own(self) -> set[_TaughtName]:
        found, seen, tasks = set[_TaughtName](), set[str](), [self._analysis.task]
        while tasks:
            task = tasks.pop()
            found.update(self._taught_in(task))
            for _, node in walk(task.root):
                if isinstance(node, Subtask) and node.task not in seen:
                    seen.add(node.task)
                    tasks += self._read(node.task)
        return found

    @cached_property
    def _others(self) -> dict[str, set[_TaughtName]]:
        files = self._files.mentioning("/teach")
        return {file: {each for task in self._read(file) for each in self._taught_in(task)} for file in files}

    def _read(self, file: str) -> list[Task]:
        try:
            return [self._files.read(file)]
        except SubtaskError:
            return []  # no task, or one that its own check tells about

    def _taught_in(self, task: Task) -> Iterator[_TaughtName]:
        for leaf in (node for _, node in walk(task.root) if isinstance(node, Leaf)):
            side, name = _TEACHERS.get(leaf.node), leaf.with_.get("name")
            if side is not None and isinstance(name, str):
                yield side, only_if_empty(leaf.with_.get(side, ""), self._parts[side]), name


def only_if_empty(name: object, parts: Collection[str]) -> str:
    """Return the arm or hand that a name means: an empty one means the only one; none of several is empty."""
    return next(iter(parts)) if name == "" and len(parts) == 1 else str(name)


_WORDS = {
    "state": ("unknown-state", "named state"),
    "taught": ("unknown-state", "taught state or pose"),
    "posture": ("unknown-state", "posture"),
    "finger": ("unknown-finger", "finger"),
    "tip": ("unknown-finger", "finger or link"),
    "link": ("unknown-link", "link"),
}
_OF_ARMS, _LEARNT = ("state", "taught"), ("state", "taught", "posture")
"""Names that an arm has; names that may be taught."""


def check_parts(analysis: TaskAnalysis) -> None:
    """Find names that the project's parts don't have, and what is wrong with the parts that the task uses."""
    leaves = [
        placed
        for placed in analysis.leaves
        if (face := placed.manifest) is not None
        and (face.id.startswith(("component/", "sensor/")) or any(p.names for p in face.parameters.values()))
    ]
    parts = analysis.catalog.parts() if leaves else None
    if parts is None:
        return
    taught_names = TaughtNames(analysis, parts)
    told: set[Problem] = set()
    for placed in leaves:
        for key, problem in _problems(placed, parts, taught_names):
            if problem.code in (UNFIT_PROJECT, MISSING_PACKAGE, NO_CONTROLLER) and problem in told:
                continue  # it is one thing to mend, however many nodes need it
            told.add(problem)
            analysis.add(placed.path, key, problem.code, problem.message, problem.fix)


def names_for(parts: ProjectParts | None, placed: PlacedNode, parameter: str) -> Collection[str]:
    """Return what a parameter of a leaf may name, for fixes; empty where nobody knows."""
    if parts is None or placed.manifest is None or parameter not in placed.manifest.parameters:
        return ()
    kind = placed.manifest.parameters[parameter].names
    if kind in ("arm", "arms", "hand"):
        return (parts.hands if kind == "hand" else parts.arms) or ()
    _, part = _part(placed, str(kind), parts)
    return () if part is None else part.known.get(str(kind), ())


def _problems(placed: PlacedNode, parts: ProjectParts, taught_names: TaughtNames) -> Iterator[tuple[Key, Problem]]:
    assert isinstance(placed.node, Leaf), "leaves are looked at"
    assert placed.manifest is not None, "those whose node is known"
    for problem in parts.nodes.get(placed.manifest.id, ()):
        yield "node", problem
    for name, parameter in placed.manifest.parameters.items():
        key: Key = ("with", name) if name in placed.node.with_ else "node"
        value = placed.node.with_.get(name, parameter.default)
        if parameter.names in ("arm", "arms", "hand"):
            side = "hand" if parameter.names == "hand" else "arm"
            for problem in _of_part(side, value, parts):
                yield key, problem
        elif parameter.names == "interface":
            for problem in _of_types(value, parts.packages):
                yield key, problem
        elif parameter.names is not None and (name in placed.node.with_ or not placed.node.in_):
            part, there = _part(placed, parameter.names, parts)
            for problem in () if there is None else _of_names(parameter.names, value, part, there, taught_names):
                yield key, problem


def _of_part(side: str, value: object, parts: ProjectParts) -> Iterator[Problem]:
    named = parts.arms if side == "arm" else parts.hands
    code = f"unknown-{side}"
    if named is None:
        return
    for name in value if isinstance(value, list | tuple) else [value]:
        if name == "" and len(named) == 1:
            yield from next(iter(named.values())).problems
        elif name == "" and named:
            yield Problem(code, f"the project has several {side}s ({listing(named)}); say which: `{side}: ...`")
        elif name in named:
            yield from named[str(name)].problems
        elif isinstance(name, str):
            hint = nearest(name, named)
            said = f"the project has no {side} {name!r}{hint}" if name else f"the project has no {side}"
            otherwise = f"name one under `{side}s` in grip.yaml"
            yield Problem(code, f"{said} (available: {listing(named)})", suggestion(hint, otherwise))


def _of_names(kind: str, value: object, part: str, there: PartNames, taught_names: TaughtNames) -> Iterator[Problem]:
    if kind not in there.known:
        return
    known = there.known[kind]
    for name in value if isinstance(value, Mapping | list | tuple) else [value]:
        if not isinstance(name, str) or not name or name in known:
            continue
        said = taught_names.problem(kind, part, name) if kind in _LEARNT else False
        if isinstance(said, Problem):
            yield said
        elif said is False:
            yield _unknown(kind, name, part, there)


def _unknown(kind: str, name: str, part: str, there: PartNames) -> Problem:
    (code, word), known = _WORDS[kind], there.known[kind]
    hint = nearest(name, known)
    otherwise = BY_TAUGHT if kind == "state" and name in there.known.get("taught", ()) else "name one of these"
    if kind == "taught":
        named = name in there.known.get("state", ())
        otherwise = f"it is a named state: {BY_STATE}" if named else f"teach it first: `grip teach {name} --arm {part}`"
    message = f"there is no {word} {name!r}{hint} (available: {listing(known)})"
    return Problem(code, message, suggestion(hint, otherwise))


def _of_types(value: object, packages: Collection[str] | None) -> Iterator[Problem]:
    for type_ in map(str, value.values() if isinstance(value, Mapping) else [value]):
        if packages is not None and "/" in type_ and (problem := missing_type(type_, packages, message=True)):
            yield problem


def _part(placed: PlacedNode, kind: str, parts: ProjectParts) -> tuple[str, PartNames | None]:
    """Return the arm or the hand that a leaf means; None where it isn't there, which is told by itself."""
    side = "arm" if kind in _OF_ARMS else "hand"
    named = (parts.arms if side == "arm" else parts.hands) or {}
    name = only_if_empty(placed.node.with_.get(side, "") if isinstance(placed.node, Leaf) else "", named)
    return name, named.get(name)


READ, PUT = "messages/get", "messages/put"


def check_messages(analysis: TaskAnalysis) -> None:
    """Find messages that are read by name, and that are neither in the project nor put by the task."""
    read = list(_messages(analysis, READ))
    names = known_messages(analysis) if read else None
    for placed, store, name in read if names is not None else ():
        there = (names or {}).get(store, ())
        if name not in there:
            hint = nearest(name, there)
            known_ones = f" (available: {listing(there)})" if there else ""
            message = f"store {store!r} has no message {name!r}{hint}{known_ones}"
            fix = suggestion(hint, f"add it to the project's messages, or put it first: `node: {PUT}`")
            analysis.add(placed.path, ("with", "name"), "unknown-message", message, fix)


def known_messages(analysis: TaskAnalysis) -> dict[str, set[str]] | None:
    """Return store -> names of the messages that are there, or that the task puts; None if nobody knows."""
    known = analysis.catalog.named()
    if known is None:
        return None
    names = {store: set(there) for store, there in known.items()}
    for _, store, name in _messages(analysis, PUT):
        names.setdefault(store, set()).add(name)
    return names


def _messages(analysis: TaskAnalysis, what: str) -> Iterator[tuple[PlacedNode, str, str]]:
    for placed in analysis.leaves:
        if isinstance(placed.node, Leaf) and placed.node.node == what:
            store, name = placed.node.with_.get("store"), placed.node.with_.get("name")
            if isinstance(store, str) and isinstance(name, str):
                yield placed, store, name


DRAWN, STOOD_IN = "x-tree", "x-stand-ins"
"""In a task: where the tree comes from that it draws; because of the drawing nothing is imported."""


def check_foreign(analysis: TaskAnalysis) -> None:
    """Find behaviours that the project doesn't list, and those that their module doesn't have."""
    code = analysis.catalog.code
    for placed in analysis.containers if DRAWN not in analysis.task.x else ():
        if not isinstance(placed.node, Foreign):
            continue
        where, built = placed.node.imported, placed.node.built_by
        listed = code.names(where) if built else code.allows(where)
        problem = not_listed(where, code.listed) if not listed else None
        if listed and not built.endswith(":__main__"):  # which is a whole program
            problem = _missing(analysis, where)
        if problem is not None:
            analysis.add(placed.path, "behaviour", problem.code, problem.message, problem.fix)


def not_listed(where: str, listed: tuple[str, ...]) -> Problem:
    """Return that a task may not import `package.module:Name`, since it isn't what its project lists."""
    hint = nearest(where, listed) or nearest(where.partition(":")[0], listed)
    there = f" (it lists: {listing(listed)})" if listed else ""
    said = f"{where!r} isn't in the project's `code:` list{hint}{there}"
    otherwise = f"if you trust it, list it in grip.yaml: `code: [{where!r}]`"
    return Problem("unlisted-code", said, suggestion(hint, otherwise))


def _missing(analysis: TaskAnalysis, where: str) -> Problem | None:
    module, _, name = where.partition(":")
    code = analysis.catalog.code
    try:
        known = code.names_in(module)
    except ModuleNotFoundError as error:
        return Problem(MISSING_PACKAGE, f"{error}, which a run imports", "install its package, or correct the path")
    first = name.partition(".")[0]
    if known is None or first in known:
        return _no_class(code, where)
    public = sorted(each for each in known if not each.startswith("_"))
    hint = nearest(first, public)
    return Problem("unknown-behaviour", f"the module {module} has no {first!r}{hint}", suggestion(hint, "correct it"))


def _no_class(code: AllowedImports, where: str) -> Problem | None:
    """Return that what a task names isn't a class, where its source tells; a function has to be listed by its name."""
    kind = code.kind_of(where)
    if kind is None or kind == "class" or code.names(where):
        return None
    if not code.is_third_party(where):
        return Problem("unknown-behaviour", f"{where!r} isn't a behaviour of py_trees", "name one of its classes")
    said = f"{where!r} is a function, which is called only if the project lists it by its name"
    return Problem("unknown-behaviour", said, f"if you trust it, list it in grip.yaml: `code: [{where!r}]`")
