"""Values as bytes and back, without pickle: what a node wrote can be looked at, exported and given to a re-execution.

The bytes are one line of JSON, then the contents of the arrays, each at a multiple of 8. In the JSON, numbers, strings,
booleans, null, lists and objects with plain keys mean themselves; anything else is an object with one key:

* `{"$array": [dtype, shape, offset]}` - offset counts from the end of the JSON line [bytes]; or a list of items
* `{"$value": [name, {field: ...}]}` - a class of `grip_bt.base.values`, a solid, or a state of the planning scene
* `{"$tuple": [...]}`, `{"$set": [...]}`, `{"$frozenset": [...]}`, `{"$bytes": base64}`, `{"$float": "nan"}`
* `{"$dict": [[key, value], ...]}` - keys that aren't strings, or begin with `$`
* `{"$opaque": [type, text]}` - can't be restored
"""

from __future__ import annotations

import base64
import json
import math
import reprlib
from dataclasses import MISSING, fields, is_dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grip_bt.base import values
from grip_bt.base.errors import GripError

_CLASSES = {name: getattr(values, name) for name in values.__all__}
_ELSEWHERE = ("grip_bt.base.values.solids", "grip_bt.commanders.scene_state")
"""Modules whose frozen dataclasses are kept too; imported when one of them comes."""
_ATOMS = (str, int, bool, type(None))
_UNCHANGING = frozenset({*_ATOMS, float, bytes, *_CLASSES.values()} - {values.Failure})
_OPAQUE_TEXT = 200
"""Characters kept of a value that can't be restored."""
DEEPEST = 100
"""Levels of containers in containers that are kept."""
_SHORT = 32
"""Items of an array that are written as numbers of JSON, at most."""


class OpaqueValueError(GripError):
    """A value of the journal can't be restored, only looked at."""

    def __init__(self, type_name: str, text: str):
        super().__init__(
            f"a {type_name} can't be restored from the journal: {text}. Values that can are those of"
            " grip_bt.base.values, numpy arrays and Python's own; have the node write one of them"
        )
        self.type_name, self.text = type_name, text


def snapshot(value: Any, depth: int = 0) -> Any:
    """Return `value` such that its writer can't change it any more: containers and arrays are copied."""
    cls = type(value)
    if cls in _UNCHANGING or (cls.__module__ in _ELSEWHERE and is_dataclass(cls)):
        return value
    if depth < DEEPEST:
        if cls in (list, tuple, set, frozenset):
            return cls(snapshot(item, depth + 1) for item in value)
        if cls is dict:
            return {key: snapshot(item, depth + 1) for key, item in value.items()}
    if cls is values.Failure:
        return values.Failure(value.code, value.message, snapshot(value.data, depth + 1))
    if isinstance(value, (np.ndarray, np.generic)) and not value.dtype.hasobject:
        return value.copy()
    return _Opaque(value)


class _Opaque:
    """What is kept of a value that nobody here knows."""

    def __init__(self, value: object):
        self.type_name = f"{type(value).__module__}.{type(value).__qualname__}"
        try:
            text = repr(value)
        except Exception as error:  # noqa: BLE001 - somebody's repr mustn't end the run
            text = f"<repr raised {type(error).__name__}>"
        self.text = text[:_OPAQUE_TEXT]

    def __repr__(self) -> str:
        return self.text


def encode(value: object) -> bytes:
    """Return the bytes of a value; what can't be restored leaves its type and the beginning of its repr."""
    arrays: list[bytes] = []
    head = json.dumps(_plain(value, arrays, [0], 0), separators=(",", ":"), ensure_ascii=False).encode() + b"\n"
    if not arrays:
        return head
    return b"".join([head[:-1], b" " * (-len(head) % 8), b"\n", *arrays])


def decode(content: bytes) -> Any:
    """Return the value, arrays read-only.

    Raises:
        OpaqueValueError: it, or something in it, can't be restored.
        ValueError: these aren't bytes of `encode`.
    """
    head, _, body = content.partition(b"\n")
    return _restored(json.loads(head), body)


def _plain(value: Any, arrays: list[bytes], size: list[int], depth: int) -> Any:
    if isinstance(value, float) and type(value) in (float, np.float64):
        return float(value) if math.isfinite(value) else {"$float": repr(float(value))}
    if type(value) in _ATOMS:
        return value
    if depth > DEEPEST:
        return _opaque(value)
    if isinstance(value, (np.ndarray, np.generic)) and not value.dtype.hasobject:
        return {"$array": _array(np.asarray(value), arrays, size)}
    name = type(value).__name__
    known = _CLASSES.get(name) is type(value) or type(value).__module__ in _ELSEWHERE
    if known and is_dataclass(value):
        kept = {f.name: _plain(getattr(value, f.name), arrays, size, depth + 1) for f in fields(value)}
        return {"$value": [name, kept]}
    if type(value) is bytes:
        return {"$bytes": base64.b64encode(value).decode()}
    if type(value) is dict:
        items = {key: _plain(item, arrays, size, depth + 1) for key, item in value.items()}
        if all(type(key) is str and not key.startswith("$") for key in items):
            return items
        return {"$dict": [[_plain(key, arrays, size, 0), item] for key, item in items.items()]}
    if type(value) in (list, tuple, set, frozenset):
        ordered = value if type(value) in (list, tuple) else sorted(value, key=repr)  # sets have an order a process
        row = [_plain(item, arrays, size, depth + 1) for item in ordered]
        return row if type(value) is list else {f"${name}": row}
    return _opaque(value)


def _array(array: NDArray[Any], arrays: list[bytes], size: list[int]) -> list[Any]:
    if array.size <= _SHORT and array.dtype.kind in "biuf" and bool(np.isfinite(array).all()):
        return [array.dtype.str, list(array.shape), array.ravel().tolist()]
    content, offset = np.ascontiguousarray(array).tobytes(), size[0]
    padding = -len(content) % 8
    arrays += [content, b"\0" * padding]
    size[0] += len(content) + padding
    return [array.dtype.str, list(array.shape), offset]


def _opaque(value: object) -> dict[str, list[str]]:
    opaque = value if isinstance(value, _Opaque) else _Opaque(value)
    return {"$opaque": [opaque.type_name, opaque.text]}


def _restored(item: object, body: bytes) -> Any:
    if isinstance(item, list):
        return [_restored(one, body) for one in item]
    if not isinstance(item, dict):
        return item
    if len(item) != 1 or not next(iter(item)).startswith("$"):
        return {key: _restored(one, body) for key, one in item.items()}
    (kind, content), *_ = item.items()
    match kind:
        case "$array":
            return _array_back(body, *content)
        case "$value":
            return _value(content[0], {key: _restored(one, body) for key, one in content[1].items()})
        case "$tuple" | "$set" | "$frozenset":
            cls = {"$tuple": tuple, "$set": set, "$frozenset": frozenset}[kind]
            return cls(_restored(one, body) for one in content)
        case "$dict":
            return {_restored(key, body): _restored(one, body) for key, one in content}
        case "$bytes":
            return base64.b64decode(content)
        case "$float":
            return float(content)
        case "$opaque":
            raise OpaqueValueError(*content)
    raise ValueError(f"{kind!r} isn't known; a newer GRIP wrote it")


def _array_back(body: bytes, dtype: str, shape: list[int], where: int | list[Any]) -> NDArray[Any]:
    if isinstance(where, list):
        array = np.array(where, dtype).reshape(shape)
        array.setflags(write=False)
        return array
    return np.frombuffer(body, dtype, math.prod(shape), where).reshape(shape)


def _value(name: str, items: dict[str, Any]) -> Any:
    """Make a value as it was, to the bit: construction would normalise quaternions once more."""
    cls = _CLASSES.get(name) or next(filter(None, (_class_in(module, name) for module in _ELSEWHERE)), None)
    if cls is None:
        raise ValueError(f"there is no value {name!r}; a newer GRIP wrote it")
    made = object.__new__(cls)
    for field in fields(cls):
        if field.name in items:
            object.__setattr__(made, field.name, items[field.name])
        elif field.default is not MISSING:  # a field that there wasn't when it was written
            object.__setattr__(made, field.name, field.default)
        elif field.default_factory is not MISSING:
            object.__setattr__(made, field.name, field.default_factory())
    return made


def _class_in(module: str, name: str) -> type | None:
    cls = getattr(import_module(module), name, None)
    return cls if isinstance(cls, type) and is_dataclass(cls) and cls.__module__ == module else None


_repr = reprlib.Repr()
_repr.maxstring, _repr.maxother, _repr.maxlist, _repr.maxtuple = 60, 100, 3, 4


def preview(value: object) -> str:
    """Return a value in at most 120 characters, for people; big values are cut before they are formatted."""
    text = _repr.repr(value)
    return text if len(text) <= 120 else text[:117] + "..."
