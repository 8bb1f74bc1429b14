"""The nodes that a project's tasks may use: GRIP's, its sensors', its components' and its own."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from grip_bt.task.catalog import AllowedImports, Catalog, TaskFolder, find_manifests, find_python_nodes
from grip_bt.task.catalog.ros_config import sensor_manifest

from .folder import Project, find_project


def project_catalog(path: str | Path) -> Catalog:
    """Return the nodes that a task file may use."""
    return catalogue_of(find_project(path))


def catalogue_of(project: Project) -> Catalog:
    """Return the built-in nodes, a project's sensors, components' nodes, own nodes and task files."""
    file = project.file
    manifests = [sensor_manifest(name, sensor) for name, sensor in file.sensors.items()]
    for folder in (file.components, file.nodes):
        if folder is not None and (project.folder / folder).is_dir():
            manifests += find_manifests(project.folder / folder)
    if file.nodes is not None:
        manifests += find_python_nodes(project.folder / file.nodes)
    return (
        Catalog.builtin()
        .with_manifests(manifests)
        .with_(
            tasks=TaskFolder(project.folder),
            named=partial(_asked, "message_names", project),
            parts=partial(_asked, "project_parts_of", project),
            code=AllowedImports(file.code, project.folder),
        )
    )


def _asked(what: str, project: Project) -> Any:
    """Ask for what a project has, which a task without arms and messages does without: it takes a while to load."""
    return getattr(import_module("grip_bt.app.project.parts"), what)(project)
