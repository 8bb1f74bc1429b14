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
    for place in list(_nodes(case["task"]["root"])):
        yield from _smaller_trees(case, place)
    for place in list(_nodes(case["task"]["root"])):
        yield from _without_keys(case, place)
    if "data" in case["task"]:
        yield _edited(case, lambda c: c["task"].pop("data"))
    if case.get("preempt_at") is not None:
        yield _edited(case, lambda c: c.pop("preempt_at"))
    yield from _shorter_scripts(case)


def _nodes(node: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield place
    for key in ("children", "child"):
        for name in node.get(key, {}):
            yield from _nodes(node[key][name], (*place, key, name))


def _at(case: Case, place: tuple[Any, ...]) -> Any:
    node = case["task"]["root"]
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
            if place:
                _at(c, place[:-1])[place[-1]] = new
            else:
                c["task"]["root"] = new

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
    for key in ("precondition", "rules", "wait_for", "cancel", "data", "exits", "outcomes", "in", "out", "meaning"):
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
