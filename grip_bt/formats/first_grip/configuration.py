"""A robot's configuration of the first GRIP: its many YAML files, each known by what is in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml.tree import parse, read_file, to_data

from .original import Note
from .settings import Key, Refused

_FILES = (".yaml", ".yml")
_OTHERS = (".xacro", ".urdf", ".launch", ".world", ".scene")


@dataclass
class Configuration:
    """What was found.

    Attributes:
        parts: kind of file -> name -> what the file says of it.
        sources: kind of file -> the files that it was read from.
        scene: a file of the collision scene.
        notes: what isn't as it was.
    """

    parts: dict[str, dict[str, Any]] = field(default_factory=dict)
    sources: dict[str, list[str]] = field(default_factory=dict)
    scene: Path | None = None
    notes: list[Note] = field(default_factory=list)

    def part(self, kind: str) -> Mapping[str, Any]:
        """Return everything of a kind by name."""
        return self.parts.get(kind, {})


def read_configuration(settings: Mapping[Key, Any], file: Path) -> Configuration:
    """Return what the files are that a robot's `.ini` names.

    A file that isn't where it was is looked for by its name below the folder of the `.ini`.
    """
    found = Configuration()
    for key, value in settings.items():
        if isinstance(value, Refused):
            found.notes.append(Note("missing", f"{file.name}:{value.line}", f"{'/'.join(key)}: {value.reason}"))
        for text in _texts(value):
            suffix = Path(text).suffix
            if suffix in (*_FILES, *_OTHERS):
                _take(found, text, file, "/".join(key))
    return found


def add_files(found: Configuration, files: Iterable[Path]) -> None:
    """Add YAML files by themselves."""
    for file in files:
        _yaml(found, file)


def _texts(value: Any) -> list[str]:
    if isinstance(value, str):
        return [value]
    return [text for each in value for text in _texts(each)] if isinstance(value, list | tuple) else []


def _take(found: Configuration, text: str, file: Path, key: str) -> None:
    path = Path(text)
    if not path.is_file():
        beside = sorted(each for each in file.parent.rglob(path.name) if each.is_file())
        if not beside:
            found.notes.append(Note("missing", file.name, f"{key}: {text} isn't there; give it by its own path"))
            return
        path = beside[0]
    if path.suffix in _FILES:
        _yaml(found, path)
    elif path.suffix == ".scene":
        found.scene = path
    elif path.suffix in (".urdf", ".xacro"):
        found.notes.append(Note("missing", path.name, "the robot's description: see docs for how a project names one"))
    else:
        what = "a launch file of ROS 1" if path.suffix == ".launch" else "a world of Gazebo"
        found.notes.append(Note("missing", path.name, f"{what} isn't imported"))


def _yaml(found: Configuration, path: Path) -> None:
    try:
        data = to_data(parse(read_file(path), str(path)))
    except DocumentError as error:
        found.notes.append(Note("missing", path.name, str(error)))
        return
    if not isinstance(data, dict) or not data:
        return
    kind = next((kind for kind, fits in _KINDS.items() if fits(data)), None)
    if kind is None:
        found.notes.append(Note("missing", path.name, "none of the formats of the first GRIP: not imported"))
        return
    known = found.parts.setdefault(kind, {})
    for name, value in data.items():
        if name in known and known[name] != value:
            found.notes.append(Note("missing", path.name, f"{name!r} stands in another file too, with another value"))
        else:
            known[name] = value
    found.sources.setdefault(kind, []).append(path.name)


def _each(test: Callable[[Any], bool]) -> Callable[[dict[str, Any]], bool]:
    return lambda data: all(test(value) for value in data.values())


def _has(*keys: str) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, dict) and set(keys) <= set(value)


def _numbers(value: Any) -> bool:
    return isinstance(value, dict) and bool(value) and all(type(each) in (int, float) for each in value.values())


def _points(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(_has("name", "interpolate_time")(each) for each in value)


_KINDS: dict[str, Callable[[dict[str, Any]], bool]] = {
    "hardware": lambda data: "robot_hardware" in data,
    "sensor plugins": lambda data: isinstance(data.get("sensors"), list),
    "poses": _each(_has("reference_frame")),
    "joint_states": _each(_numbers),
    "trajectories": _each(_points),
    "components": _each(_has("action/service")),
    "planners": _each(_has("planner_name")),
    "sensors": _each(_has("data_topics")),
    "controllers": _each(_has("type")),
}
