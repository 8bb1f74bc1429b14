"""What settings files there are: where they lie, their shape, and templates to begin with."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from grip_bt.app.project.folder import ProjectFile
from grip_bt.base.errors import DocumentError
from grip_bt.base.message_store.files import read_joint_states, read_poses, read_trajectories
from grip_bt.base.yaml.models import Diagnostic, check_model
from grip_bt.base.yaml.tree import YamlValue, parse, to_data
from grip_bt.task.catalog.component_file import ComponentFile
from grip_gui.project import OutsideProjectError, ProjectFolder
from grip_gui.wire.setup import SetupEntry, Template
from grip_sim.worlds.model import WorldFile

JOINT_STATES, POSES, TRAJECTORIES = (f"messages/{name}.yaml" for name in ("joint_states", "poses", "trajectories"))


@dataclass(frozen=True)
class Kind:
    """One kind of settings file, `name` on the wire."""

    name: str
    title: str
    doc: str
    blank: str
    """The text of a new file."""
    shape: Mapping[str, Any]
    """JSON Schema of its data."""
    templates: Sequence[Template]
    """Values to begin with."""
    check: Callable[[Path, str, YamlValue], list[Diagnostic]]
    """Returns what is wrong with a text that is YAML."""


def _by_reader(read: Callable[[Path, str], object]) -> Callable[[Path, str, YamlValue], list[Diagnostic]]:
    """Check by the room that reads such files, beside those that it refers to."""

    def check(file: Path, text: str, _tree: YamlValue) -> list[Diagnostic]:
        try:
            read(file, text)
        except DocumentError as error:
            return [(error.message, error.line or 1, error.column or 1)]
        return []

    return check


def _trajectories(file: Path, text: str) -> object:
    states = file.with_name("joint_states.yaml")
    return read_trajectories(file, read_joint_states(states) if states.is_file() else {}, text)


_SHAPES = json.loads(Path(__file__).with_name("shapes.json").read_text("utf-8"))
"""Made from the models by tools/settings_reference.py, since only their sources say what each key means."""
_SAID = to_data(parse(Path(__file__).with_name("kinds.yaml").read_text("utf-8")))


def _kind(name: str, check: Callable[[Path, str, YamlValue], list[Diagnostic]], **shape: Mapping[str, Any]) -> Kind:
    said = {**_SAID[name], **shape}
    templates = [Template(**each) for each in said.pop("templates", ())]
    return Kind(name, templates=templates, check=check, **said)


def _by_model(name: str, model: type[BaseModel]) -> Kind:
    return _kind(name, lambda _file, _text, tree: check_model(tree, model)[1], shape=_SHAPES[name])


PROJECT, COMPONENT = _by_model("project", ProjectFile), _by_model("component", ComponentFile)
WORLD = _by_model("world", WorldFile)
_MESSAGES = {
    JOINT_STATES: _kind("joint_states", _by_reader(read_joint_states)),
    POSES: _kind("poses", _by_reader(read_poses)),
    TRAJECTORIES: _kind("trajectories", _by_reader(_trajectories)),
}
_WORLD_PATH = re.compile(r"^worlds/[A-Za-z0-9_]+\.yaml$")
_COMPONENT_PATH = re.compile(r"^[A-Za-z0-9_./-]+/[A-Za-z0-9_-]+/component\.yaml$|^[A-Za-z0-9_-]+/component\.yaml$")


def kind_of(path: str) -> Kind:
    """Return what a file is by its path; one that is none of a project's settings files is refused."""
    if path == "grip.yaml":
        return PROJECT
    if path in _MESSAGES:
        return _MESSAGES[path]
    if _WORLD_PATH.match(path):
        return WORLD
    if _COMPONENT_PATH.match(path):
        return COMPONENT
    known = f"grip.yaml, {', '.join(_MESSAGES)}, components, worlds"
    raise OutsideProjectError(path, f"isn't a settings file (available: {known})")


def entries(folder: ProjectFolder, components: Mapping[str, Path]) -> list[SetupEntry]:
    """Return all settings files of a project, those that could be made among them."""
    paths = {"grip.yaml": PROJECT, **_MESSAGES}
    found = [(path, kind, kind.title) for path, kind in paths.items()]
    worlds = sorted((folder.folder / "worlds").glob("*.yaml"), reverse=True)
    found[1:1] = [(folder.relative(file), WORLD, f"World {file.stem}") for file in worlds if file.stem.isidentifier()]
    for name, home in components.items():
        path = folder.relative(home / "component.yaml")
        found.insert(1, (path, COMPONENT, f"Component {name}"))
    return [
        SetupEntry(path=path, kind=kind.name, title=title, exists=(folder.folder / path).is_file(), doc=kind.doc)
        for path, kind, title in found
    ]
