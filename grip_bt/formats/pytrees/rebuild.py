"""Somebody's own behaviour as a foreign node: its import path and literal arguments, when these make the same again."""

from __future__ import annotations

import inspect
import sys
from typing import Any

from py_trees.behaviour import Behaviour

from .kinds import NoEqual

_OF_A_RUN = {
    *("id", "iterator", "logger", "parent", "children", "status", "feedback_message"),
    *("qualified_name", "blackbox_level", "blackboards"),
}
"""Attributes that every behaviour has and that say nothing of how it was made."""


def foreign_of(behaviour: Behaviour, name: str) -> dict[str, Any]:
    """Return the keys of a foreign node that makes a behaviour like this one.

    Each argument of its constructor is looked for in an attribute of the same name. Whether these are right is seen
    by making one: its attributes have to be equal.

    Args:
        behaviour: without children.
        name: of the node.

    Raises:
        NoEqual: it can't be made again of literals; the text says why.
    """
    cls = type(behaviour)
    where = f"{cls.__module__}:{cls.__qualname__}"
    if cls.__module__ == "__main__" or _imported(cls) is not cls:
        raise NoEqual(f"{cls.__qualname__} can't be imported by a name")
    if behaviour.children:
        raise NoEqual(f"{where} has children, and is no class that a task has")
    args: dict[str, Any] = {}
    for parameter in inspect.signature(cls).parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.name != "name":
            value = getattr(behaviour, parameter.name, parameter.empty)
            if not _literal(value):
                raise NoEqual(f"{where}: which {parameter.name!r} it was made with isn't known as a literal")
            if type(value) is not type(parameter.default) or value != parameter.default:
                args[parameter.name] = value
        elif behaviour.name != name:
            args["name"] = behaviour.name
    _compare(behaviour, where, args, "name" in inspect.signature(cls).parameters)
    return {"kind": "foreign", "behaviour": where, **({"args": args} if args else {})}


def _imported(cls: type) -> Any:
    """Return what other programs find under the name of a class."""
    found: Any = sys.modules.get(cls.__module__)
    for name in cls.__qualname__.split("."):
        found = getattr(found, name, None)
    return found


def _literal(value: Any) -> bool:
    if isinstance(value, list):
        return all(map(_literal, value))
    if isinstance(value, dict):
        return all(isinstance(key, str) and _literal(item) for key, item in value.items())
    return value is None or type(value) in (bool, int, float, str)


def _compare(behaviour: Behaviour, where: str, args: dict[str, Any], named: bool) -> None:
    given = {**({"name": behaviour.name} if named else {}), **args}
    try:
        again = type(behaviour)(**given)
    except Exception as error:
        raise NoEqual(f"{where} can't be made again: {type(error).__name__}: {error}") from error
    mine, other = vars(behaviour), vars(again)
    for name in (mine.keys() | other.keys()) - _OF_A_RUN:
        if name not in mine or name not in other or not _equal(mine[name], other[name]):
            raise NoEqual(f"{where}: made again its {name!r} would be another one")


def _equal(one: Any, other: Any) -> bool:
    try:
        return type(one) is type(other) and bool(one == other)
    except Exception:  # noqa: BLE001 - what can't be compared isn't known to be equal
        return False
