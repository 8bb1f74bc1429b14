"""The processes of a project, from `grip.yaml` to a group that runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grip_bt.base.errors import UnknownNameError
from grip_bt.ros.launch.group import Member
from grip_bt.ros.process import child_environment
from grip_bt.ros.starting import command_of
from grip_bt.task.catalog.process_config import ProcessConfig

from .project import Project


def project_members(project: Project, names: Sequence[str] = (), domain_id: int | None = None) -> list[Member]:
    """Return the processes of a project; all of those that are to be run, where none is named.

    Raises:
        UnknownNameError: the project has no such process.
        PackageError: a package, its program or its launch file isn't here.
    """
    declared = project.file.processes
    for name in names:
        if name not in declared:
            raise UnknownNameError("process", name, declared, str(project.folder / "grip.yaml"))
    wanted = names or [name for name, config in declared.items() if config.run]
    return [_member(name, declared[name], project.folder, domain_id) for name in wanted]


def _member(name: str, config: ProcessConfig, project: Path, domain_id: int | None) -> Member:
    return Member(
        name,
        command_of(config, project),
        project / (config.folder or "."),
        child_environment((), domain_id) | dict(config.env),
        config.ready,
        config.restart,
        config.restarts,
        config.restart_delay,
        config.required,
    )
