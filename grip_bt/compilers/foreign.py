"""Behaviours that a task names by their import path: imported and made when the task is compiled, and only then."""

from __future__ import annotations

import inspect
from importlib import import_module
from typing import Any

from py_trees.behaviour import Behaviour

from grip_bt.errors import InvalidTaskError
from grip_bt.graph.model import Foreign
from grip_bt.validation import Issue


def adopt(path: str, name: str, node: Foreign) -> Behaviour:
    """Return the behaviour of a foreign node.

    Args:
        path: the node's path.
        name: the node's name, which the behaviour gets where its constructor takes a `name` and `args` has none.
        node: what the document says.

    Raises:
        InvalidTaskError: there is nothing at the import path, it can't be made of these arguments, or what it makes
            isn't a behaviour.
    """
    make = _found(path, node.behaviour)
    given: dict[str, Any] = dict(node.args)
    try:
        if "name" not in given and "name" in inspect.signature(make).parameters:
            given["name"] = name
        made = make(**given)
    except Exception as error:
        raise _refused(path, f"{node.behaviour} can't be made of `args`: {type(error).__name__}: {error}") from error
    if not isinstance(made, Behaviour):
        raise _refused(path, f"{node.behaviour} makes a {type(made).__name__}, not a py_trees Behaviour")
    if made.parent is not None:
        raise _refused(path, f"{node.behaviour} makes a behaviour that is part of another tree already")
    return made


def _found(path: str, where: str) -> Any:
    module, _, attributes = where.partition(":")
    try:
        found: Any = import_module(module)
        for attribute in attributes.split("."):
            found = getattr(found, attribute)
    except Exception as error:
        raise _refused(path, f"{where} can't be imported: {type(error).__name__}: {error}") from error
    if not callable(found):
        raise _refused(path, f"{where} is a {type(found).__name__}; name a class or a function that makes a behaviour")
    return found


def _refused(path: str, message: str) -> InvalidTaskError:
    return InvalidTaskError([Issue(path, "unknown-behaviour", "error", message)])
