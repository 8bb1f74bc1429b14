"""What is wrong with a file's data, said with line and column."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from grip_bt.errors import DocumentError

from .syntax import Entry, Mapping, Value

Fault = tuple[str, int, int]
"""Message, line, column; both 1-based."""
_PASSED_OVER = {"children", "child", "Variable", "str", "leaf"}


def fault_of(tree: Mapping, error: Any) -> Fault:
    """Return one of pydantic's errors, from data that stands in `tree`, in words and with its place."""
    path = [step for step in error["loc"] if step != "[key]"]
    line, column = find(tree, path)
    words = _readable(path)
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "missing":
        message = f"the key {words[-1]!r} is missing"
        words = words[:-1]
    elif error["type"] == "string_pattern_mismatch" and words[-1:] == ["behaviour"]:
        message = f"{error['input']!r} isn't an import path: write `package.module:Class`"
    elif error["type"] == "string_pattern_mismatch":
        message = f"{error['input']!r} isn't a name: letters, digits, _, - and spaces, a letter or _ first"
    elif error["type"] == "union_tag_not_found":
        message = "a node is a mapping with `node:` or `kind:`"
    elif error["type"] in ("too_long", "too_short"):
        message = f"{path[-1]!r} takes {_amount(error)}, not {error['ctx']['actual_length']}"
    elif not isinstance(error["input"], dict | list):
        message += f", not {error['input']!r}"
    at = "/".join(words)
    return (f"{at}: {message}" if at else message, line, column)


def _amount(error: Any) -> str:
    limits = error["ctx"]
    if "max_length" in limits:
        return f"at most {limits['max_length']}"
    return f"at least {limits['min_length']}"


def _readable(path: Iterable[Any]) -> list[str]:
    return [str(step) for step in path if step not in _PASSED_OVER]


def find(tree: Value, path: Iterable[Any]) -> tuple[int, int]:
    """Return line and column of what stands at a path of keys and indices, or of the nearest place above it.

    Steps that aren't keys (pydantic names the branches of a union) are passed over.
    """
    line, column = tree.line, tree.column
    value = tree
    for step in path:
        entry: Entry | None = None
        if isinstance(value, Mapping):
            entry = value.entries.get(str(step))
        elif isinstance(step, int) and not hasattr(value, "value") and step < len(value.entries):
            entry = value.entries[step]
        if entry is not None:
            line, column, value = entry.line, entry.column, entry.value
    return line, column


def document_error(faults: list[Fault], source: str) -> DocumentError:
    """Return the error for several faults: placed at the first one, with the others in its message."""
    faults = sorted(set(faults), key=lambda fault: fault[1:])
    message, line, column = faults[0]
    others = [f"\n  also {line}:{column}: {text}" for text, line, column in faults[1:10]]
    if len(faults) > 10:
        others.append(f"\n  and {len(faults) - 10} more")
    return DocumentError(message + "".join(others), source, line, column)
