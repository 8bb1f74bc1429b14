"""A YAML file whose shape is a pydantic model: read safely, with line and column of all that is wrong with its data."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from types import UnionType
from typing import Annotated, TypeVar, Union, cast, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.yaml.tree import YamlMapping, YamlValue, inner, parse, read_file, to_data

Diagnostic = tuple[str, int, int]
"""Message, line, column; both 1-based."""
_KEYS_OF_NODES = ("children", "child")
_PASSED_OVER = {*_KEYS_OF_NODES, "Variable", "str", "leaf"}
M = TypeVar("M", bound=BaseModel)
T = TypeVar("T")


def read_model(path: Path | str, model: type[M]) -> M:
    """Read a file as `model`.

    Raises:
        DocumentError: it can't be read or doesn't fit; with line and column, and the nearest allowed key.
    """
    return cast("M", _model_of(read_file(path), str(path), model))


@lru_cache(maxsize=256)  # campaigns read the same files for each trial
def _model_of(text: str, source: str, model: type[M]) -> M:
    begins = f"it holds {listing(model.model_fields)}"
    found, faults = check_model(parse(text, source, begins=begins), model)
    if found is None:
        raise document_error(faults, source)
    return found


def check_model(tree: YamlValue, model: type[M], name: str = "the file") -> tuple[M | None, list[Diagnostic]]:
    """Return what was parsed as `model`, or None and all that keeps it from being one, each with its place."""
    if not isinstance(tree, YamlMapping):
        return None, [(f"a mapping with {listing(model.model_fields)}", tree.line, tree.column)]
    try:
        return model.model_validate(to_data(tree)), []
    except ValidationError as error:
        errors = error.errors()
    unknown = [e["loc"] for e in errors if e["type"] == "extra_forbidden"]
    faults = [_unknown_key(tree, model, where, name) for where in unknown]
    for e in errors:
        above, kind = e["loc"][:-1], e["type"]
        # what is missing may be what is misspelt; other forms of what a misspelt key stands in aren't meant
        told = kind == "missing" or (kind.endswith("_type") and any(above == where[: len(above)] for where in unknown))
        if kind != "extra_forbidden" and not (unknown and told):
            faults.append(diagnostic_of(tree, e))
    return None, faults


def _unknown_key(tree: YamlMapping, model: type[BaseModel], where: tuple[int | str, ...], name: str) -> Diagnostic:
    value, at, key = cast("YamlValue", tree), list[str](), str(where[-1])
    for step in where[:-1]:  # pydantic names the branches of a union, too
        if (entry := inner(value, step)) is not None:
            value = entry.value
            at.append(str(step))
    allowed = [field.alias or n for n, field in next(_models_at(model, where[:-1])).model_fields.items()]
    message = f"unknown key {key!r} in {'/'.join(at) or name}{nearest(key, allowed)} (available: {listing(allowed)})"
    return (message, *find(tree, where))


def _models_at(annotation: object, where: tuple[int | str, ...]) -> Iterator[type[BaseModel]]:
    """Yield the models that stand at a place of a type, as pydantic's errors name places."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        fields = {field.alias or name: field.annotation for name, field in annotation.model_fields.items()}
        if not where:
            yield annotation
        elif where[0] in fields:
            yield from _models_at(fields[str(where[0])], where[1:])
        elif re.search(rf"\b{annotation.__name__}\b", str(where[0])):  # the branch of a union
            yield from _models_at(annotation, where[1:])
        return
    itself = get_origin(annotation) in (Union, UnionType, Annotated)
    for part in get_args(annotation):
        yield from _models_at(part, where if itself else where[1:])


def validated(adapter: TypeAdapter[T], tree: YamlMapping, source: str) -> T:
    """Return what was parsed as a type. Raises DocumentError: it doesn't fit; with line and column."""
    try:
        return adapter.validate_python(to_data(tree))
    except ValidationError as error:
        raise document_error([diagnostic_of(tree, fault) for fault in error.errors()], source) from None


def diagnostic_of(tree: YamlMapping, error: ErrorDetails) -> Diagnostic:
    """Return one of pydantic's errors, from data that stands in `tree`, in words and with its place."""
    path = [step for step in error["loc"] if step != "[key]"]
    line, column = find(tree, path)
    words = [str(step) for step in path if step not in _PASSED_OVER]
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "missing" and isinstance(path[-1], int):
        message, words = f"it has {len(error['input'])} numbers, which are too few", words[:-1]
    elif error["type"] == "missing":
        message = f"the key {words[-1]!r} is missing"
        words = words[:-1]
    elif error["type"] == "extra_forbidden" and words:
        message = f"there is no key {words[-1]!r}; keys are those of the file"
        words = words[:-1]
    elif error["type"] == "string_pattern_mismatch" and words[-1:] == ["behaviour"]:
        message = f"{error['input']!r} isn't an import path: write `package.module:Class`"
    elif error["type"] == "string_pattern_mismatch":
        asked = next(words for mark, words in _PATTERNS.items() if mark in error["ctx"]["pattern"])
        message = f"{error['input']!r} isn't {asked}"
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


_PATTERNS = {
    "^(/": "a whole ROS name: words of letters, digits and _, each after a /, such as /camera/points",
    "(srv|action|msg)": "the name of an interface: package/srv/Name, package/action/Name or package/msg/Name",
    "^[a-z][a-z0-9_]*(": "a path of fields: lower case names with dots between them, such as target.pose",
    "^[a-z]": "a name: lower case letters, digits and _, a letter first, such as my_grasps",
    "^[A-Za-z_][A-Za-z0-9_]*$": "a name: letters, digits and _, no digit first",
    "": "a name: letters, digits, _, - and spaces, a letter or _ first",
}
"""What is in a pattern of ours -> what it asks for, in words."""


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

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


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
