"""Behaviours that a task names by their import path: imported and made when the task is compiled to be run, only then.

What may be imported is what the project lists, and py_trees' own behaviours; it is known to be a class of behaviours
before it is called. A function is called only where the project lists it by its name.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

from py_trees.behaviour import Behaviour

from grip_bt.base.errors import InvalidTaskError
from grip_bt.base.issue import Issue
from grip_bt.task.catalog import AllowedImports
from grip_bt.task.model import Foreign
from grip_bt.task.validation.parts import not_listed

BehaviourFactory = Callable[[str, str, Foreign], Behaviour]
"""(path, name, what the document says) -> the behaviour of a foreign node."""


def adopter(code: AllowedImports) -> BehaviourFactory:
    """Return what imports and makes the behaviours of foreign nodes, of such code as a project lists."""

    def adopt(path: str, name: str, node: Foreign) -> Behaviour:
        """Return the behaviour of a foreign node.

        Args:
            path: the node's path.
            name: the node's name, which the behaviour gets where its constructor takes a `name` and `args` has none.
            node: what the document says.

        Raises:
            InvalidTaskError: it isn't listed, there is nothing at the import path, it isn't a class of behaviours or a
                function that is listed, it can't be made of these arguments, or what it makes isn't a behaviour.
        """
        make = _maker(path, node.behaviour, code)
        given: dict[str, Any] = dict(node.args)
        try:
            if "name" not in given and "name" in inspect.signature(make).parameters:
                given["name"] = name
            made = make(**given)
        except Exception as error:
            reason = f"{node.behaviour} can't be made of `args`: {type(error).__name__}: {error}"
            raise _refused(path, reason) from error
        if not isinstance(made, Behaviour):
            raise _refused(path, f"{node.behaviour} makes a {type(made).__name__}, not a py_trees Behaviour")
        if made.parent is not None:
            raise _refused(path, f"{node.behaviour} makes a behaviour that is part of another tree already")
        return made

    return adopt


def _maker(path: str, where: str, code: AllowedImports) -> Any:
    """Return what is at an import path, where it may be called."""
    if not code.allows(where):
        trouble = not_listed(where, code.listed)
        raise InvalidTaskError([Issue(path, trouble.code, "error", trouble.message, trouble.fix)])
    found = _found(path, where, code)
    if isinstance(found, type) and issubclass(found, Behaviour):
        return found
    if isinstance(found, type) or not callable(found):
        what = "a class" if isinstance(found, type) else f"a {type(found).__name__}"
        raise _refused(path, f"{where} is {what}, and no Behaviour of py_trees; name a class of behaviours")
    if not code.names(where):
        raise _refused(
            path,
            f"{where} is a function, which is called only if the project lists it by its name: "
            f"`code: [{where!r}]` in grip.yaml",
        )
    return found


def _found(path: str, where: str, code: AllowedImports) -> Any:
    module, _, attributes = where.partition(":")
    if code.folder is not None and code.is_third_party(where) and str(code.folder) not in sys.path:
        sys.path.append(str(code.folder))  # last: nothing in a project takes the place of what is installed
    try:
        found: Any = import_module(module)
        for attribute in attributes.split("."):
            found = getattr(found, attribute)
    except Exception as error:
        raise _refused(path, f"{where} can't be imported: {type(error).__name__}: {error}") from error
    return found


def _refused(path: str, message: str) -> InvalidTaskError:
    return InvalidTaskError([Issue(path, "unknown-behaviour", "error", message)])
