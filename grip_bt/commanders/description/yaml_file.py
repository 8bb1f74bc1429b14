"""YAML files of MoveIt and ROS: read safely, with their `!degrees` and `!radians`, as mappings."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from grip_bt.base.errors import DocumentError, nearest

from .reading import note

LARGEST = 4 * 1024 * 1024
brief = reprlib.Repr().repr


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML has no types
    pass


def _turned(factor: float) -> Any:
    def construct(loader: yaml.SafeLoader, node: yaml.Node) -> float:
        try:
            return float(loader.construct_scalar(node)) * factor
        except (ValueError, TypeError):
            raise yaml.constructor.ConstructorError(
                None, None, "an angle has to be a number", node.start_mark
            ) from None

    return construct


_Loader.add_constructor("!degrees", _turned(math.pi / 180))
_Loader.add_constructor("!radians", _turned(1.0))


def read_yaml(path: Path) -> dict[str, Any]:
    """Return a file's mapping; an empty file is an empty one. A ROS 2 parameter file gives its parameters.

    Raises:
        DocumentError: it isn't YAML, or isn't a mapping.
    """
    note(path)
    if path.stat().st_size > LARGEST:
        raise DocumentError(f"it has more than {LARGEST // 2**20} MiB", str(path))
    try:
        data = yaml.load(path.read_bytes(), _Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = (mark.line + 1, mark.column + 1) if mark is not None else (None, None)
        raise DocumentError(f"isn't YAML: {error.problem or error}", str(path), *place) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise DocumentError(f"isn't YAML: {' '.join(str(error).split())}", str(path)) from None
    if data is None:
        return {}
    if not isinstance(data, dict):
        raise DocumentError(f"has to hold a mapping, not a {type(data).__name__}", str(path))
    return _parameters(data)


def _parameters(data: dict[Any, Any]) -> dict[str, Any]:
    """Return what a ROS 2 parameter file wraps in `node: ros__parameters:`."""
    if len(data) == 1:
        (inner,) = data.values()
        if isinstance(inner, dict) and isinstance(inner.get("ros__parameters"), dict):
            return _parameters(inner["ros__parameters"])
    return {str(key): value for key, value in data.items()}


class Reading:
    """Takes entries out of a mapping that was read from a file, and says where what has to be.

    Args:
        source: the file.
    """

    def __init__(self, source: Path):
        self.source = str(source)

    def mapping(self, value: object, where: str) -> Mapping[str, Any]:
        """Return a mapping with keys as text; nothing is an empty one.

        Raises:
            DocumentError: it is something else.
        """
        if value is None:
            return {}
        if not isinstance(value, dict):
            raise DocumentError(f"{where} has to be a mapping, not {brief(value)}", self.source)
        return {str(key): entry for key, entry in value.items()}

    def number(self, value: object, where: str) -> float:
        """Return a finite number.

        Raises:
            DocumentError: it is something else.
        """
        try:
            number = float(value) if isinstance(value, (int, float, str)) and not isinstance(value, bool) else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise DocumentError(f"{where} has to be a finite number, not {brief(value)}", self.source)
        return number

    def words(self, value: object, where: str) -> tuple[str, ...]:
        """Return a list of texts.

        Raises:
            DocumentError: it is something else.
        """
        if value is None:
            return ()
        if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
            raise DocumentError(f"{where} has to be a list of names, not {brief(value)}", self.source)
        return tuple(value)

    def known(self, key: str, mapping: Mapping[str, Any], where: str) -> Any:
        """Return an entry that mustn't be missing.

        Raises:
            DocumentError: it is.
        """
        if key not in mapping:
            raise DocumentError(f"{where} lacks {key!r}{nearest(key, mapping)}", self.source)
        return mapping[key]
