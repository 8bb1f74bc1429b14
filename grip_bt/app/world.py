"""Worlds made in Python, with the same values as the file `worlds/NAME.yaml` of a project."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, Literal

import yaml

from grip_bt.app.project.folder import Project
from grip_bt.base.files import replace_text
from grip_sim.specs import WorldSpec
from grip_sim.worlds import WorldFile, arrange, read_world


class World(WorldFile):
    """A simulated world: `grip.World(fixtures={"table": {"box": [0.7, 1.2, 0.1], "at": [0.65, 0, -0.1]}}, ...)`.

    `grip.World("table")` is a built-in one, or that of a file, as it is or with other fields.
    Its fields, with units and frames, are those of the file; see docs/world_file.md.

    Raises:
        pydantic.ValidationError: no world can be so; it names the field and what is allowed.
        UnknownNameError, DocumentError: there is no world of that name, or its file is wrong.
    """

    grip: Literal[1] = 1

    def __init__(self, name: str = "", /, **fields: Any):
        said = read_world(name)[0].model_dump(exclude_unset=True, by_alias=True) if name else {}
        super().__init__(**said | fields)

    @classmethod
    def like(cls, name: str, project: Path | None = None) -> World:
        """Return a built-in world, or one of a project's folder, or of a file, to be changed by `model_copy`.

        Raises:
            UnknownNameError, DocumentError: there is no such world, or its file is wrong.
        """
        return cls.model_validate(read_world(name, project)[0].model_dump(exclude_unset=True, by_alias=True))

    def arranged(self, seed: int = 0) -> WorldSpec:
        """Return what a seed draws: every object with its pose in world, size [m] and mass [kg].

        Raises:
            ArrangementError: drawn objects don't fit where they are to be.
        """
        return arrange(self, seed, Path())

    def save(self, file: str | Path) -> Path:
        """Write it as a world's file, and return its path; files that it names are relative to that."""
        said = {"grip": 1, **self.model_dump(mode="json", by_alias=True, exclude_unset=True)}
        replace_text(Path(file), yaml.safe_dump(said, sort_keys=False, allow_unicode=True, default_flow_style=None))
        return Path(file).absolute()

    def kept_in(self, folder: Path) -> Path:
        """Write it into a folder by a name of its content, and return its path."""
        folder.mkdir(parents=True, exist_ok=True)
        return self.save(folder / f"{sha256(self.model_dump_json().encode()).hexdigest()[:16]}.yaml")


def in_world(project: Project, world: str | None) -> Project:
    """Return a project with another simulated world, where one is named."""
    return project if not world else replace(project, file=project.file.model_copy(update={"world": world}))
