"""A robot's files: which were read, what was found about them, and YAML with MoveIt's and ROS's tags."""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Generic, TypeVar

import yaml

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.issue import Issue, Severity

K = TypeVar("K", bound=Hashable)
T = TypeVar("T")
Stamps = tuple[tuple[str, int, int], ...]
"""Of each file: its path, when it was written [ns] and its size [B]; 0 and -1 where it isn't there."""
_files: ContextVar[set[Path] | None] = ContextVar("files", default=None)


@contextmanager
def noting_files() -> Iterator[set[Path]]:
    """Collect the files that are read by this thread from here on."""
    outer, files = _files.get(), set[Path]()
    token = _files.set(files)
    try:
        yield files
    finally:
        _files.reset(token)
        if outer is not None:
            outer |= files


def note(*paths: Path) -> None:
    """Say that files are read, or looked for."""
    files = _files.get()
    if files is not None:
        files.update(path.absolute() for path in paths)


_MOST = 16
"""Things that are kept."""


class FileCache(Generic[K, T]):
    """What was made of files, made again when one of them has changed; of so many keys, the newest ones."""

    def __init__(self) -> None:
        self._made: dict[K, tuple[Stamps, T]] = {}

    def get(self, key: K, make: Callable[[], T]) -> T:
        """Return what `make` makes of the files that it notes, see `note`."""
        if key not in self._made or any(stamp != _stamp(stamp[0]) for stamp in self._made[key][0]):
            with noting_files() as files:
                made = make()
            self._made.pop(key, None)
            while len(self._made) >= _MOST:
                self._made.pop(next(iter(self._made)))
            self._made[key] = tuple(_stamp(str(file)) for file in sorted(files)), made
        return self._made[key][1]


def _stamp(file: str) -> tuple[str, int, int]:
    try:
        found = Path(file).stat()
    except OSError:
        return file, 0, -1
    return file, found.st_mtime_ns, found.st_size


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
    """Return an entry of a file as a finite number.

    Raises:
        DocumentError: it is something else.
    """
    try:
        number = float(value) if isinstance(value, int | float | str) and not isinstance(value, bool) else math.nan
    except (ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise DocumentError(f"{where} has to be a finite number, not {brief(value)}", str(source))
    return number
