"""Any YAML file whose shape is a pydantic model: read safely, with the place of every fault."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from grip_bt.base.errors import listing, nearest
from grip_bt.base.yaml.files import read_file

from .faults import Fault, document_error, fault_of
from .syntax import Mapping, Value, parse, plain

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


def check_model(tree: Value, model: type[M]) -> tuple[M | None, list[Fault]]:
    """Return what was parsed as `model`, or None and all that keeps it from being one, each with its place."""
    if not isinstance(tree, Mapping):
        return None, [(f"a mapping with {listing(model.model_fields)}", tree.line, tree.column)]
    faults = list(_unknown_keys(tree, model, "the file"))
    try:
        found = model.model_validate(plain(tree))
    except ValidationError as error:
        errors = error.errors()
        mistyped = {e["loc"][0] for e in errors if e["type"] == "extra_forbidden" and e["loc"]} if faults else set()
        return None, faults + [fault_of(tree, e) for e in errors if not _is_told(e["loc"], e["type"], mistyped, tree)]
    return (None, faults) if faults else (found, [])


def _is_told(where: tuple[int | str, ...], kind: str, mistyped: set[int | str], tree: Mapping) -> bool:
    """Tell whether an error comes of an unknown key, which is told elsewhere: itself, or another form of its field."""
    if not where or where[0] not in mistyped:
        return False
    value = tree.entries[str(where[0])].value if str(where[0]) in tree.entries else None
    of_form = len(where) == 2 and not (isinstance(value, Mapping) and str(where[1]) in value.entries)
    return kind == "extra_forbidden" or (of_form and kind.endswith("_type"))


def _unknown_keys(tree: Value, model: type[BaseModel], name: str) -> Iterator[Fault]:
    if not isinstance(tree, Mapping):
        return
    allowed = {field.alias or key: field for key, field in model.model_fields.items()}
    for key, entry in tree.entries.items():
        if key not in allowed:
            message = f"unknown key {key!r} in {name}{nearest(key, allowed)} (there are: {listing(allowed)})"
            yield message, entry.line, entry.column
            continue
        for inner, value in _models_below(allowed[key].annotation, entry.value, key):
            yield from _unknown_keys(value, inner[1], inner[0])


def _models_below(annotation: object, value: Value, name: str) -> Iterator[tuple[tuple[str, type[BaseModel]], Value]]:
    """Yield the models that a field holds, itself or as the values of a dict, with their part of the file."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield (name, annotation), value
        return
    if get_origin(annotation) in (Union, UnionType):
        for member in get_args(annotation):
            yield from _models_below(member, value, name)
        return
    models = [a for a in get_args(annotation) if isinstance(a, type) and issubclass(a, BaseModel)]
    if models and isinstance(value, Mapping):
        for key, entry in value.entries.items():
            yield (f"{name}/{key}", models[0]), entry.value
