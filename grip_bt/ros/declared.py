"""Declared port types as Python types: `list[Grasp]` -> `list[grip_bt.values.Grasp]`."""

from __future__ import annotations

import ast
from functools import cache
from typing import Any

from grip_bt import values
from grip_bt.errors import UnknownNameError

_BUILTINS = {"bool": bool, "int": int, "float": float, "str": str, "list": list, "dict": dict, "None": None, "Any": Any}
_KNOWN: dict[str, Any] = {**_BUILTINS, **{name: getattr(values, name) for name in values.__all__}}


@cache
def python_type(text: str) -> Any:
    """Return the Python type that a declared type names; `Any` for a ROS type, which stays a message.

    Raises:
        UnknownNameError: a name in it isn't a value type or a builtin.
    """
    if text.count("/") >= 1:
        return Any
    try:
        return _build(ast.parse(text, mode="eval").body, text)
    except SyntaxError:
        raise UnknownNameError("type", text, _KNOWN) from None


def _build(node: ast.expr, text: str) -> Any:
    if isinstance(node, ast.Name) and node.id in _KNOWN:
        return _KNOWN[node.id]
    if isinstance(node, ast.Constant) and node.value is None:
        return None
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitOr):
        return _build(node.left, text) | _build(node.right, text)
    if isinstance(node, ast.Subscript):
        outer, inner = _build(node.value, text), node.slice
        if outer is list:
            return list[_build(inner, text)]  # type: ignore[misc]
        if outer is dict and isinstance(inner, ast.Tuple) and len(inner.elts) == 2:
            key, item = (_build(e, text) for e in inner.elts)
            return dict[key, item]  # type: ignore[valid-type]
    raise UnknownNameError("type", ast.unparse(node), _KNOWN, where=text)
