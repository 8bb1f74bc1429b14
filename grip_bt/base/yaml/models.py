"""A YAML file whose shape is a pydantic model: read safely, with line and column of all that is wrong with its data."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import UnionType
from typing import Annotated, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError
from pydantic_core import ErrorDetails

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.yaml.tree import YamlList, YamlMapping, YamlValue, inner, parse, read_file, to_data

Diagnostic = tuple[str, int, int]
"""Message, line, column; both 1-based."""
_KEYS_OF_NODES = ("children", "child")
_PASSED_OVER = {*_KEYS_OF_NODES, "Variable", "str", "leaf"}
M = TypeVar("M", bound=BaseModel)


def read_model(path: Path | str, model: type[M]) -> M:
    """Read a file as `model`.

    Raises:
        DocumentError: it can't be read or doesn't fit; with line and column, and the nearest allowed key.
    """
    source = str(path)
    begins = f"it holds {listing(model.model_fields)}"
    found, faults = check_model(parse(read_file(path), source, begins=begins), model)
    if found is None:
        raise document_error(faults, source)
    return found


def check_model(tree: YamlValue, model: type[M], name: str = "the file") -> tuple[M | None, list[Diagnostic]]:
    """Return what was parsed as `model`, or None and all that keeps it from being one, each with its place."""
    if not isinstance(tree, YamlMapping):
        return None, [(f"a mapping with {listing(model.model_fields)}", tree.line, tree.column)]
    faults = list(_unknown_keys(tree, model, name))
    try:
        found = model.model_validate(to_data(tree))
    except ValidationError as error:
        # what is missing may be what is misspelt
        errors = [e for e in error.errors() if not (faults and e["type"] == "missing")]
        mistyped = {e["loc"][0] for e in errors if e["type"] == "extra_forbidden" and e["loc"]} if faults else set()
        return None, faults + [
            diagnostic_of(tree, e) for e in errors if not _is_told(e["loc"], e["type"], mistyped, tree)
        ]
    return (None, faults) if faults else (found, [])


def _is_told(where: tuple[int | str, ...], kind: str, mistyped: set[int | str], tree: YamlMapping) -> bool:
    """Tell whether an error comes of an unknown key, which is told elsewhere: itself, or another form of its field."""
    if not where or where[0] not in mistyped:
        return False
    value = tree.entries[str(where[0])].value if str(where[0]) in tree.entries else None
    of_form = len(where) == 2 and not (isinstance(value, YamlMapping) and str(where[1]) in value.entries)
    return kind == "extra_forbidden" or (of_form and kind.endswith("_type"))


def _unknown_keys(tree: YamlValue, model: type[BaseModel], name: str) -> Iterator[Diagnostic]:
    if not isinstance(tree, YamlMapping):
        return
    allowed = {field.alias or key: field for key, field in model.model_fields.items()}
    for key, entry in tree.entries.items():
        if key not in allowed:
            message = f"unknown key {key!r} in {name}{nearest(key, allowed)} (available: {listing(allowed)})"
            yield message, entry.line, entry.column
            continue
        for (where, part), value in _models_below(allowed[key].annotation, entry.value, key):
            yield from _unknown_keys(value, part, where)


def _models_below(
    annotation: object, value: YamlValue, name: str
) -> Iterator[tuple[tuple[str, type[BaseModel]], YamlValue]]:
    """Yield the models that a field holds, itself or as the values of a dict or a list, with their part of the file."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield (name, annotation), value
        return
    if get_origin(annotation) in (Union, UnionType):
        for member in get_args(annotation):
            yield from _models_below(member, value, name)
        return
    models = [a for a in get_args(annotation) if isinstance(a, type) and issubclass(a, BaseModel)]
    if models and isinstance(value, YamlMapping):
        for key, entry in value.entries.items():
            yield (f"{name}/{key}", models[0]), entry.value
    if models and isinstance(value, YamlList):
        for index, entry in enumerate(value.entries):
            yield (f"{name}/{index}", models[0]), entry.value


def diagnostic_of(tree: YamlMapping, error: ErrorDetails) -> Diagnostic:
    """Return one of pydantic's errors, from data that stands in `tree`, in words and with its place."""
    path = [step for step in error["loc"] if step != "[key]"]
    line, column = find(tree, path)
    words = [str(step) for step in path if step not in _PASSED_OVER]
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "missing":
        message = f"the key {words[-1]!r} is missing"
        words = words[:-1]
    elif error["type"] == "extra_forbidden" and words:
        message = f"there is no key {words[-1]!r}; keys are those of the file"
        words = words[:-1]
    elif error["type"] == "string_pattern_mismatch" and words[-1:] == ["behaviour"]:
        message = f"{error['input']!r} isn't an import path: write `package.module:Class`"
    elif error["type"] == "string_pattern_mismatch":
        message = _mismatch(error["ctx"]["pattern"], error["input"])
    elif error["type"] == "tuple_type" and isinstance(error["input"], str | int | float):
        items = ", ".join(f'"{word}"' if "{" in word else word for word in re.findall(r"[^,\s]+", str(error["input"])))
        message = f"expected a list: write [{items}], not {error['input']!r}"
    elif error["type"] == "union_tag_not_found":
        message = "a node is a mapping with `node:` or `kind:`"
    elif error["type"] == "dict_type":
        nodes = [path[-1]] if path[-1:] and path[-1] in _KEYS_OF_NODES else []
        such = f", such as `{nodes[0]}: {{first: {{node: flow/succeed}}}}`" if nodes else ""
        words += nodes
        message = f"expected a mapping with a name for each entry{such}, not {_kind_of(error['input'])}"
    elif error["type"] in ("too_long", "too_short"):
        limits = error["ctx"]
        amount = f"at most {limits['max_length']}" if "max_length" in limits else f"at least {limits['min_length']}"
        message = f"{path[-1]!r} takes {amount}, not {limits['actual_length']}"
    elif not isinstance(error["input"], dict | list) and repr(error["input"]) not in message:
        message += f", not {error['input']!r}"
    at = "/".join(words)
    return (f"{at}: {message}" if at else message, line, column)


def _kind_of(value: object) -> str:
    if isinstance(value, list | tuple):
        return "a list"
    return "nothing" if value is None else repr(value)


def _mismatch(pattern: str, text: object) -> str:
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
    words = [word for word in re.split(r"[^A-Za-z0-9_]+", str(text)) if word]
    return "".join(f"/{'_' * word[0].isdigit()}{word}" for word in words) or "/camera/points"


def find(tree: YamlValue, path: Iterable[str | int]) -> tuple[int, int]:
    """Return line and column of what stands at a path of keys and indices, or of the nearest place above it.

    Steps that aren't keys (pydantic names the branches of a union) are passed over.
    """
    line, column = tree.line, tree.column
    value: YamlValue = tree
    for step in path:
        entry = inner(value, step)
        if entry is not None:
            line, column, value = entry.line, entry.column, entry.value
    return line, column


def document_error(faults: Iterable[Diagnostic], source: str) -> DocumentError:
    """Return the error for several faults: placed at the first one, with the others in its message."""
    faults = sorted(set(faults), key=lambda fault: fault[1:])
    message, line, column = faults[0]
    others = [f"\n  also {line}:{column}: {text}" for text, line, column in faults[1:10]]
    if len(faults) > 10:
        others.append(f"\n  and {len(faults) - 10} more")
    return DocumentError(message + "".join(others), source, line, column)


Identifier = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
RosName = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]
"""A whole name: of a topic, service, action or namespace."""


class Settings(BaseModel):
    """A part of a settings file: frozen, and nothing else is allowed in it."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True, defer_build=True)


Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


def exactly_one(settings: Settings, keys: Sequence[str], shown: str = "") -> None:
    """Check that one of several keys is given.

    Args:
        shown: how the choice is written where the keys alone don't tell it.

    Raises:
        ValueError: none of them is given, or several are.
    """
    given = [key for key in keys if getattr(settings, key)]
    if len(given) != 1:
        here = " and ".join(given) or "none of them"
        raise ValueError(f"give exactly one of {shown or ', '.join(f'`{key}`' for key in keys)}; here: {here}")
