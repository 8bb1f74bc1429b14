"""Making a failing case small: try every simpler case until none of them fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

Case = dict[str, Any]
Place = list[Any]


def shrink(case: Case, fails: Callable[[Case], bool], limit: int = 3000) -> Case:
    """Return a case that still fails and of which no simpler neighbour does.

    Args:
        case: a failing case.
        fails: tells whether a case fails; it must answer False for an invalid one.
        limit: how many cases to try at most.
    """
    tried = 0
    while True:
        for candidate in simpler(case):
            tried += 1
            if tried > limit:
                return case
            if fails(candidate):
                case = candidate
                break
        else:
            return case


def simpler(case: Case) -> Iterator[Case]:
    """Yield cases with something left out, the big steps first."""
    for place in list(_places(case)):
        yield from _smaller_trees(case, place)
    for place in list(_places(case)):
        yield from _without_keys(case, place)
    used = {_at(case, place).get("task") for place in _places(case)}
    for file in set(case.get("files", {})) - used:
        yield _edited(case, lambda c, file=file: c["files"].pop(file))
    if "data" in case["task"]:
        yield _edited(case, lambda c: c["task"].pop("data"))
    if case.get("preempt_at") is not None:
        yield _edited(case, lambda c: c.pop("preempt_at"))
    for what in case.get("outside", {}):
        yield _edited(case, lambda c, what=what: c["outside"].pop(what))
    yield from _shorter_scripts(case)


def _nodes(node: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield place
    for key in ("children", "child"):
        for name in node.get(key, {}):
            yield from _nodes(node[key][name], (*place, key, name))


def _places(case: Case) -> Iterator[tuple[Any, ...]]:
    """Yield where the nodes of the task and of its files are."""
    yield from _nodes(case["task"]["root"], ("task", "root"))
    for file, task in case.get("files", {}).items():
        yield from _nodes(task["root"], ("files", file, "root"))


def _at(case: Case, place: tuple[Any, ...]) -> Any:
    node: Any = case
    for key in place:
        node = node[key]
    return node


def _edited(case: Case, edit: Callable[[Case], Any]) -> Case:
    copy = deepcopy(case)
    edit(copy)
    return copy


def _smaller_trees(case: Case, place: tuple[Any, ...]) -> Iterator[Case]:
    node = _at(case, place)
    key = "children" if "children" in node else "child"
    for name, child in node.get(key, {}).items():

        def lift(c: Case, child: Any = child) -> None:
            new = deepcopy(child)
            new.pop("on", None)
            if "on" in node:
                new["on"] = deepcopy(node["on"])
            _at(c, place[:-1])[place[-1]] = new

        yield _edited(case, lift)
        if key == "children" and len(node["children"]) > 1:

            def drop(c: Case, name: str = name) -> None:
                parent = _at(c, place)
                del parent["children"][name]
                if "exits" in parent:
                    parent["exits"] = {k: v for k, v in parent["exits"].items() if k.split(".")[0] != name}

            yield _edited(case, drop)


def _without_keys(case: Case, place: tuple[Any, ...]) -> Iterator[Case]:
    node = _at(case, place)
    for key in (
        "precondition",
        "rules",
        "wait_for",
        "cancel",
        "retick",
        "prompt",
        "data",
        "exits",
        "outcomes",
        "in",
        "with",
        "out",
        "meaning",
    ):
        if key in node:
            yield _edited(case, lambda c, key=key: _at(c, place).pop(key))
    for key in ("on", "exits"):
        for label in node.get(key, {}):
            yield _edited(case, lambda c, key=key, label=label: _at(c, place)[key].pop(label))


def _shorter_scripts(case: Case) -> Iterator[Case]:
    for name, steps in case["scripts"].items():
        for index, step in enumerate(steps):
            if len(steps) > 1:
                yield _edited(case, lambda c, name=name, index=index: c["scripts"][name].pop(index))
            for key in set(step) - {"outcome"}:
                yield _edited(case, lambda c, n=name, i=index, key=key: c["scripts"][n][i].pop(key))
