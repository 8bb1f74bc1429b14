"""What is wrong with a file's data, said with line and column."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from grip_bt.base.errors import DocumentError

from .syntax import Entry, Mapping, Value

Fault = tuple[str, int, int]
"""Message, line, column; both 1-based."""
_KEYS_OF_NODES = ("children", "child")
_PASSED_OVER = {*_KEYS_OF_NODES, "Variable", "str", "leaf"}


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
        message = mismatch(error["ctx"]["pattern"], error["input"])
    elif error["type"] == "tuple_type" and isinstance(error["input"], str | int | float):
        message = f"a list is wanted: write [{', '.join(str(error['input']).split())}], not {error['input']!r}"
    elif error["type"] == "union_tag_not_found":
        message = "a node is a mapping with `node:` or `kind:`"
    elif error["type"] == "dict_type":
        nodes = [path[-1]] if path[-1:] and path[-1] in _KEYS_OF_NODES else []
        such = f", such as `{nodes[0]}: {{first: {{node: flow/succeed}}}}`" if nodes else ""
        words += nodes
        message = f"a mapping is wanted, with a name for each entry{such}, not {_kind_of(error['input'])}"
    elif error["type"] in ("too_long", "too_short"):
        message = f"{path[-1]!r} takes {_amount(error)}, not {error['ctx']['actual_length']}"
    elif not isinstance(error["input"], dict | list) and repr(error["input"]) not in message:
        message += f", not {error['input']!r}"
    at = "/".join(words)
    return (f"{at}: {message}" if at else message, line, column)


def _kind_of(value: object) -> str:
    if isinstance(value, list | tuple):
        return "a list"
    return "nothing" if value is None else repr(value)


def mismatch(pattern: str, text: object) -> str:
    """Return what is wrong with a text that has to match a pattern of ours, in words, with what could be written."""
    if pattern.startswith("^(/"):
        allowed = "words of letters, digits and _, each after a /"
        return f"{text!r} isn't a whole ROS name: {allowed}, such as {_ros_name(text)}"
    if "(srv|action|msg)" in pattern:
        allowed = "package/srv/Name, package/action/Name or package/msg/Name"
        return f"{text!r} isn't the name of an interface: {allowed}, such as std_srvs/srv/Trigger"
    if pattern.startswith("^[a-z][a-z0-9_]*("):
        return f"{text!r} isn't a path of fields: lower case names with dots between them, such as target.pose"
    if pattern.startswith("^[a-z]"):
        lower = "_".join(re.findall(r"[a-z0-9]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", str(text)).lower()))
        such = lower if lower[:1].isalpha() else "my_grasps"
        return f"{text!r} isn't a name: lower case letters, digits and _, a letter first, such as {such}"
    if pattern == r"^[A-Za-z_][A-Za-z0-9_]*$":
        return f"{text!r} isn't a name: letters, digits and _, no digit first"
    return f"{text!r} isn't a name: letters, digits, _, - and spaces, a letter or _ first"


def _ros_name(text: object) -> str:
    """Return the whole ROS name that somebody may have meant."""
    words = [word for word in re.split(r"[^A-Za-z0-9_]+", str(text)) if word]
    return "".join(f"/{'_' * word[0].isdigit()}{word}" for word in words) or "/camera/points"


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
