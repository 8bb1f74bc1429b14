"""What somebody who names a robot by one word means: a ready-made one, a file, or a folder."""

from __future__ import annotations

from pathlib import Path

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.yaml.models import check_model, document_error, read_model
from grip_bt.base.yaml.tree import YamlMapping, parse, read_file, to_data

from .config import RobotConfig
from .reading import note

PROJECT = "grip.yaml"


def is_ready_made(word: str) -> bool:
    """Tell whether a word is a ready-made robot's name."""
    from ..robots import ROBOTS

    return word in ROBOTS


def config_of(word: str, folder: Path) -> tuple[RobotConfig, Path]:
    """Return the configuration that a path stands for, and the folder that its relative paths begin in.

    `*.urdf`, `*.xacro` and `*.xml` (MJCF) are robots by themselves, `*.yaml` holds a configuration, a `grip.yaml` under
    `robot:`. A folder is a project, or a MoveIt configuration package.

    Raises:
        UnknownNameError: there is neither such a file nor such a ready-made robot.
        DocumentError: the file is of another kind, or its configuration is wrong.
    """
    path = (folder / Path(word).expanduser()).resolve()
    if path.is_dir() and not (path / PROJECT).is_file():
        return RobotConfig(moveit=str(path)), path.parent
    if path.is_dir():
        path = path / PROJECT
    note(path)
    if not path.is_file():
        if "/" in word or path.suffix:
            raise DocumentError("there is no such file", str(path))
        from ..robots import ROBOTS

        raise UnknownNameError("robot", word, ROBOTS, where="neither a file nor ready-made")
    kinds = {".urdf": "urdf", ".xacro": "xacro", ".xml": "mjcf"}
    if path.suffix in kinds:
        return RobotConfig(**{kinds[path.suffix]: str(path)}), path.parent
    if path.name == PROJECT:
        return _of_project(path), path.parent
    if path.suffix in (".yaml", ".yml"):
        return read_model(path, RobotConfig), path.parent
    raise DocumentError(
        "a robot is a .urdf, .xacro, .xml (MJCF) or .yaml file, or a MoveIt package's folder", str(path)
    )


def _of_project(path: Path) -> RobotConfig:
    tree = parse(read_file(path), str(path))
    entry = tree.entries.get("robot") if isinstance(tree, YamlMapping) else None
    if entry is None:
        raise DocumentError("the project names no `robot:`", str(path))
    if isinstance(word := to_data(entry.value), str):
        return RobotConfig(ready=word)
    config, faults = check_model(entry.value, RobotConfig)
    if config is None:
        raise document_error(faults, str(path))
    return config
