"""A robot's files: what was found about them, and YAML with MoveIt's and ROS's tags."""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import yaml

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.issue import Issue, Severity
from grip_bt.commanders.description.file_cache import note


def robot_issue(severity: Severity, code: str, message: str, source: str = "", line: int | None = None) -> Issue:
    """Return what was found about a robot's files; an `error` keeps the robot from being used."""
    return Issue("robot", code, severity, message, source=source, line=line)


def finding_of(error: GripError) -> Issue:
    """Return an error of reading as a finding."""
    if isinstance(error, DocumentError):
        return robot_issue("error", "bad-file", error.message, error.source, error.line)
    return robot_issue("error", "bad-robot", str(error))


def errors(findings: Iterable[Issue]) -> list[Issue]:
    """Return those that keep the robot from being used."""
    return [finding for finding in findings if finding.severity == "error"]


_ARGUMENT = re.compile(rb"\$\(arg \w+\)|\$\{\w*prefix\w*\}")
"""Of names that launch files put a prefix before, which is empty here."""
LARGEST = 4 * 1024 * 1024
brief = reprlib.Repr().repr


class _Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML has no types
    pass


def _turned(factor: float) -> Callable[[yaml.SafeLoader, yaml.Node], float]:
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


def read_yaml(path: Path) -> dict[str, object]:
    """Return a file's mapping; an empty file is an empty one. A ROS 2 parameter file gives its parameters.

    Raises:
        DocumentError: it isn't YAML, or isn't a mapping.
    """
    note(path)
    if path.stat().st_size > LARGEST:
        raise DocumentError(f"it has more than {LARGEST // 2**20} MiB", str(path))
    try:
        data = yaml.load(_ARGUMENT.sub(b"", path.read_bytes()), _Loader)
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


def _parameters(data: Mapping[object, object]) -> dict[str, object]:
    """Return what a ROS 2 parameter file wraps in `node: ros__parameters:`."""
    if len(data) == 1:
        (inner,) = data.values()
        if isinstance(inner, dict) and isinstance(inner.get("ros__parameters"), dict):
            return _parameters(inner["ros__parameters"])
    return {str(key): value for key, value in data.items()}


def mapping_of(value: object, where: str, source: Path) -> Mapping[str, object]:
    """Return an entry of a file as a mapping with keys as text; nothing is an empty one.

    Raises:
        DocumentError: it is something else.
    """
    if not isinstance(value, dict | None):
        raise DocumentError(f"{where} has to be a mapping, not {brief(value)}", str(source))
    return {str(key): entry for key, entry in (value or {}).items()}


def finite(value: object, where: str, source: Path) -> float:
    """Return an entry of a file as a finite number. Raises DocumentError: it is something else."""
    try:
        number = float(value) if isinstance(value, int | float | str) and not isinstance(value, bool) else math.nan
    except (ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise DocumentError(f"{where} has to be a finite number, not {brief(value)}", str(source))
    return number
