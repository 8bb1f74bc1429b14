"""Names of a project's parts, of its messages and of its own code."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Foreign, Leaf
from grip_bt.task.catalog import AllowedImports, Manifest
from grip_bt.task.catalog.project_parts import MISSING, UNFIT, UNMOVED, Equipment, Equipped, Trouble, missing_type

from .codes import suggestion
from .survey import Key, Spot, Survey
from .taught import BY_STATE, Lessons, only_if_empty

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


def check_equipment(survey: Survey) -> None:
    """Find names that the project's parts don't have, and what is wrong with the parts that the task uses."""
    leaves = [spot for spot in survey.leaves if spot.manifest is not None and _concerns(spot.manifest)]
    equipment = survey.catalog.equipment() if leaves else None
    if equipment is None:
        return
    lessons = Lessons(survey, equipment)
    told: set[Trouble] = set()
    for spot in leaves:
        for key, trouble in _troubles(spot, equipment, lessons):
            if trouble.code in (UNFIT, MISSING, UNMOVED) and trouble in told:
                continue  # it is one thing to mend, however many nodes need it
            told.add(trouble)
            survey.add(spot.path, key, trouble.code, trouble.message, trouble.fix)


def names_for(equipment: Equipment | None, spot: Spot, parameter: str) -> Collection[str]:
    """Return what a parameter of a leaf may name, for fixes; empty where nobody knows."""
    if equipment is None or spot.manifest is None or parameter not in spot.manifest.parameters:
        return ()
    kind = spot.manifest.parameters[parameter].names
    if kind in ("arm", "arms", "hand"):
        return (equipment.hands if kind == "hand" else equipment.arms) or ()
    _, part = _part(spot, str(kind), equipment)
    return () if part is None else part.known.get(str(kind), ())


def _concerns(manifest: Manifest) -> bool:
    return manifest.id.startswith(("component/", "sensor/")) or any(p.names for p in manifest.parameters.values())


def _troubles(spot: Spot, equipment: Equipment, lessons: Lessons) -> Iterator[tuple[Key, Trouble]]:
    assert isinstance(spot.node, Leaf), "leaves are looked at"
    assert spot.manifest is not None, "those whose node is known"
    for trouble in equipment.nodes.get(spot.manifest.id, ()):
        yield "node", trouble
    for name, parameter in spot.manifest.parameters.items():
        key: Key = ("with", name) if name in spot.node.with_ else "node"
        value = spot.node.with_.get(name, parameter.default)
        if parameter.names in ("arm", "arms", "hand"):
            side = "hand" if parameter.names == "hand" else "arm"
            for trouble in _of_part(side, value, equipment):
                yield key, trouble
        elif parameter.names == "interface":
            for trouble in _of_types(value, equipment.packages):
                yield key, trouble
        elif parameter.names is not None and (name in spot.node.with_ or not spot.node.in_):
            part, there = _part(spot, parameter.names, equipment)
            for trouble in () if there is None else _of_names(parameter.names, value, part, there, lessons):
                yield key, trouble


def _of_part(side: str, value: object, equipment: Equipment) -> Iterator[Trouble]:
    """Yield that there is no such arm or hand, else what is wrong with it."""
    parts = equipment.arms if side == "arm" else equipment.hands
    code = f"unknown-{side}"
    if parts is None:
        return
    for name in value if isinstance(value, list | tuple) else [value]:
        if name == "" and len(parts) == 1:
            yield from next(iter(parts.values())).troubles
        elif name == "" and parts:
            yield Trouble(code, f"the project has several {side}s ({listing(parts)}); say which: `{side}: ...`")
        elif name in parts:
            yield from parts[str(name)].troubles
        elif isinstance(name, str):
            hint = nearest(name, parts)
            said = f"the project has no {side} {name!r}{hint}" if name else f"the project has no {side}"
            otherwise = f"name one under `{side}s` in grip.yaml"
            yield Trouble(code, f"{said} (available: {listing(parts)})", suggestion(hint, otherwise))


def _of_names(kind: str, value: object, part: str, there: Equipped, lessons: Lessons) -> Iterator[Trouble]:
    """Yield which of the names that a literal holds aren't there; an empty one stands for nothing or for a default."""
    if kind not in there.known:
        return
    known, taught = there.known[kind], there.known.get("taught", ())
    for name in value if isinstance(value, Mapping | list | tuple) else [value]:
        if not isinstance(name, str) or not name or name in known:
            continue
        said = lessons.trouble(kind, part, name, taught) if kind in _LEARNT else False
        if isinstance(said, Trouble):
            yield said
        elif said is False:
            yield _unknown(kind, name, part, there)


def _unknown(kind: str, name: str, part: str, there: Equipped) -> Trouble:
    (code, word), known = _WORDS[kind], there.known[kind]
    hint = nearest(name, known)
    otherwise = "name one of these"
    if kind == "taught":
        named = name in there.known.get("state", ())
        otherwise = f"it is a named state: {BY_STATE}" if named else f"teach it first: `grip teach {name} --arm {part}`"
    message = f"there is no {word} {name!r}{hint} (available: {listing(known)})"
    return Trouble(code, message, suggestion(hint, otherwise))


def _of_types(value: object, packages: Collection[str] | None) -> Iterator[Trouble]:
    for type_ in value.values() if isinstance(value, Mapping) else [value]:
        trouble = (
            missing_type(str(type_), packages, message=True) if packages is not None and "/" in str(type_) else None
        )
        if trouble is not None:
            yield trouble


def _part(spot: Spot, kind: str, equipment: Equipment) -> tuple[str, Equipped | None]:
    """Return the arm or the hand that a leaf means; None where it isn't there, which is told by itself."""
    side = "arm" if kind in _OF_ARMS else "hand"
    parts = (equipment.arms if side == "arm" else equipment.hands) or {}
    name = only_if_empty(spot.node.with_.get(side, "") if isinstance(spot.node, Leaf) else "", parts)
    return name, parts.get(name)


READ, PUT = "messages/get", "messages/put"


def check_messages(survey: Survey) -> None:
    """Find messages that are read by name, and that are neither in the project nor put by the task."""
    read = [spot for spot in survey.leaves if isinstance(spot.node, Leaf) and spot.node.node == READ]
    names = known_messages(survey) if read else None
    if names is None:
        return
    for spot in read:
        store, name = _place(spot)
        if isinstance(store, str) and isinstance(name, str) and name not in names.get(store, ()):
            there = names.get(store, ())
            hint = nearest(name, there)
            known_ones = f" (available: {listing(there)})" if there else ""
            survey.add(
                spot.path,
                ("with", "name"),
                "unknown-message",
                f"nothing is called {name!r} in the store {store!r}{hint}{known_ones}",
                suggestion(hint, f"add it to the project's messages, or put it first: `node: {PUT}`"),
            )


def known_messages(survey: Survey) -> dict[str, set[str]] | None:
    """Return store -> names of the messages that are there, or that the task puts; None if nobody knows."""
    known = survey.catalog.named()
    if known is None:
        return None
    names = {store: set(there) for store, there in known.items()}
    for store, name in _put(survey.leaves):
        names.setdefault(store, set()).add(name)
    return names


def _put(leaves: list[Spot]) -> Iterator[tuple[str, str]]:
    for spot in leaves:
        if isinstance(spot.node, Leaf) and spot.node.node == PUT:
            store, name = _place(spot)
            if isinstance(store, str) and isinstance(name, str):
                yield store, name


def _place(spot: Spot) -> tuple[object, object]:
    assert isinstance(spot.node, Leaf), "leaves read and put messages"
    return spot.node.with_.get("store"), spot.node.with_.get("name")


def check_foreign(survey: Survey) -> None:
    """Find behaviours that the project doesn't list, and those that their module doesn't have."""
    code = survey.catalog.code
    for spot in survey.containers:
        if not isinstance(spot.node, Foreign):
            continue
        where = spot.node.behaviour
        trouble = _missing(survey, where) if code.allows(where) else not_listed(where, code.listed)
        if trouble is not None:
            survey.add(spot.path, "behaviour", trouble.code, trouble.message, trouble.fix)


def not_listed(where: str, listed: tuple[str, ...]) -> Trouble:
    """Return that a task may not import `package.module:Name`, since it isn't what its project lists."""
    hint = nearest(where, listed) or nearest(where.partition(":")[0], listed)
    there = f" (it lists: {listing(listed)})" if listed else ""
    said = f"{where!r} is no code that the project lets its tasks import{hint}{there}"
    otherwise = f"if you trust it, list it in grip.yaml: `code: [{where!r}]`"
    return Trouble("unlisted-code", said, suggestion(hint, otherwise))


def _missing(survey: Survey, where: str) -> Trouble | None:
    """Return that a module isn't here or lacks a name, as far as its source tells."""
    module, _, name = where.partition(":")
    code = survey.catalog.code
    try:
        known = code.names_in(module)
    except ModuleNotFoundError as error:
        return Trouble(MISSING, f"{error}, which a run imports", "install its package, or correct the path")
    first = name.partition(".")[0]
    if known is None or first in known:
        return _no_class(code, where)
    public = sorted(each for each in known if not each.startswith("_"))
    hint = nearest(first, public)
    return Trouble("unknown-behaviour", f"the module {module} has no {first!r}{hint}", suggestion(hint, "correct it"))


def _no_class(code: AllowedImports, where: str) -> Trouble | None:
    """Return that what a task names isn't a class, where its source tells; a function has to be listed by its name."""
    kind = code.kind_of(where)
    if kind is None or kind == "class" or code.names(where):
        return None
    if not code.is_third_party(where):
        return Trouble("unknown-behaviour", f"{where!r} is no behaviour of py_trees", "name one of its classes")
    said = f"{where!r} is a function, which is called only if the project lists it by its name"
    return Trouble("unknown-behaviour", said, f"if you trust it, list it in grip.yaml: `code: [{where!r}]`")
