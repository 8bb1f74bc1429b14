"""Changes of single values of a YAML text; comments, order and style of everything else stay."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import YAMLError

from grip_bt.base.errors import GripError, nearest

WIDTH = 140


class UnchangeableError(GripError):
    """A value can't be put into a text."""


def set_value(text: str, key: Sequence[str | int], value: object) -> str:
    """Return the text with a value put at a path of keys; mappings on the way are made.

    Raises:
        UnchangeableError: the text is no mapping in YAML, or something else stands on the way.
    """
    yaml, root = _loaded(text)
    parent = _parent(root, key, make=True)
    if isinstance(parent, list):
        at = _index(parent, key)
        if at == len(parent):
            parent.append(value)
        else:
            parent[at] = value
    else:
        parent[key[-1]] = value
    return _dumped(yaml, root)


def remove(text: str, key: Sequence[str | int]) -> str:
    """Return the text without what stands at a path of keys, and without mappings that this leaves empty above it."""
    yaml, root = _loaded(text)
    parent = _parent(root, key)
    if isinstance(parent, list):
        del parent[_index(parent, key)]
    else:
        _there(parent, key)
        del parent[key[-1]]
    for depth in range(len(key) - 1, 0, -1):
        above = _parent(root, key[:depth])
        if above[key[depth - 1]] or above[key[depth - 1]] == 0:
            break
        del above[key[depth - 1]]
    return _dumped(yaml, root)


def rename(text: str, key: Sequence[str | int], name: str) -> str:
    """Return the text with another name for an entry, in its place; those that refer to it follow.

    Raises:
        UnchangeableError: the new name is taken, or there is no such entry.
    """
    yaml, root = _loaded(text)
    parent, old = _parent(root, key), key[-1]
    if not isinstance(parent, CommentedMap):
        raise UnchangeableError(f"{_said(key)} has no name")
    _there(parent, key)
    if name in parent and name != old:
        raise UnchangeableError(f"{name!r} is taken; choose another name than {', '.join(map(str, parent))}")
    _rename_key(parent, old, name)
    if len(key) == 2:
        _follow(root, key[0], old, name)
    return _dumped(yaml, root)


def _rename_key(mapping: CommentedMap, old: object, new: str) -> None:
    """Give an entry another name, in its place and with its comment."""
    place, value, comment = list(mapping).index(old), mapping[old], mapping.ca.items.pop(old, None)
    del mapping[old]
    mapping.insert(place, new, value)
    if comment is not None:
        mapping.ca.items[new] = comment


def _follow(root: CommentedMap, kind: object, old: object, new: str) -> None:
    """Have those that refer to an arm, a hand or a sensor call it by its new name."""
    arms, ros = root.get("arms"), root.get("ros")
    for arm in arms.values() if kind == "hands" and isinstance(arms, dict) else ():
        if isinstance(arm, dict) and arm.get("hand") == old:
            arm["hand"] = new
    where = {"hands": "controllers", "arms": "controllers", "sensors": "cameras"}.get(str(kind))
    users = ros.get(where) if isinstance(ros, dict) else None
    if isinstance(users, CommentedMap) and old in users and new not in users:
        _rename_key(users, old, new)


def _loaded(text: str) -> tuple[YAML, Any]:
    yaml = YAML(typ="rt")
    yaml.preserve_quotes = True
    yaml.width = WIDTH
    yaml.indent(mapping=2, sequence=4, offset=2)
    try:
        root = yaml.load(text)
    except (YAMLError, ValueError, RecursionError) as error:
        reason = str(error).splitlines()[0]
        raise UnchangeableError(f"fix the text first, it is not valid YAML: {reason}") from None
    if root is None or (isinstance(root, dict) and not root):
        root = CommentedMap()
    if not isinstance(root, dict):
        raise UnchangeableError("fix the text first: it is not a mapping of keys to values")
    return yaml, root


def _dumped(yaml: YAML, root: object) -> str:
    out = io.StringIO()
    yaml.dump(root, out)
    return out.getvalue()


def _parent(root: Any, key: Sequence[str | int], make: bool = False) -> Any:
    at = root
    for depth, step in enumerate(key[:-1]):
        if isinstance(at, list):
            at = at[_index(at, key[: depth + 1])]
            continue
        if make and at.get(step) is None:
            at[step] = CommentedSeq() if isinstance(key[depth + 1], int) else CommentedMap()
        _there(at, key[: depth + 1])
        at = at[step]
        if not isinstance(at, dict | list):
            raise UnchangeableError(f"{_said(key[: depth + 1])} is {at!r}, with nothing in it; remove it first")
    return at


def _there(parent: Any, key: Sequence[str | int]) -> None:
    if key[-1] not in parent:
        raise UnchangeableError(f"{_said(key)} isn't there{nearest(str(key[-1]), map(str, parent))}")


def _index(parent: list[Any], key: Sequence[str | int]) -> int:
    at = key[-1]
    if not isinstance(at, int) or not 0 <= at <= len(parent):
        raise UnchangeableError(f"{_said(key)} isn't there: the list has {len(parent)} entries")
    return at


def _said(key: Sequence[str | int]) -> str:
    return "/".join(map(str, key))
