"""Parameters of ROS with a default in the text: where a machine's shape hangs on one, it is taken, and told."""

from __future__ import annotations

import ast
import copy
import reprlib
from collections.abc import Callable, Collection
from typing import Any

from .found import UNKNOWN, Opaque

GET_PARAMETER = "rospy.get_param"
_METHODS = ("items", "keys", "values", "get")


def default_given(arguments: list[Any], named: dict[str, Any]) -> Any:
    """Return the default in a call of `get_param`; `UNKNOWN` where it has none."""
    return arguments[1] if len(arguments) > 1 else named.get("default", UNKNOWN)


def repeatable(node: ast.expr, functions: Collection[str], methods: Collection[str]) -> bool:
    """Tell whether evaluating an expression twice is as good as once: it makes nothing and changes nothing.

    Args:
        node: the expression.
        functions: builtin functions that change nothing.
        methods: methods of text that change nothing.
    """
    for each in ast.walk(node):
        if isinstance(each, (ast.Lambda, ast.NamedExpr, ast.Await, ast.Yield)):
            return False
        if isinstance(each, ast.Call):
            callee = each.func
            name = callee.attr if isinstance(callee, ast.Attribute) else getattr(callee, "id", "")
            plain = name in functions if isinstance(callee, ast.Name) else name in methods or name in _METHODS
            if not plain and name != "get_param":
                return False
    return True


def assumed(value: Any) -> Any:
    """Return the default of what only a run knows, where the text gives one; else the value itself."""
    known = isinstance(value, Opaque) and value.default is not UNKNOWN
    return copy.deepcopy(value.default) if known else value


def taken(value: Any, note: Callable[[str], None]) -> Any:
    """Return a value, or the default that is taken for it, and note that.

    Args:
        value: what was read.
        note: is given the words, where a default is taken.
    """
    found = assumed(value)
    if found is not value:
        note(words(value, found))
    return found


def words(value: Opaque, default: Any) -> str:
    """Return what is told where a default is taken."""
    return (
        f"`{value.text}` is taken as {reprlib.repr(default)}, by the default in the text; with other parameters of ROS,"
        " which only a run knows, the machine is another"
    )
