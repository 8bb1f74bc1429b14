"""The processes of a project, from `grip.yaml` to a group that runs."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape

from jinja2 import Environment

from grip_bt.app.project.folder import Project
from grip_bt.base.errors import UnknownNameError
from grip_bt.ros.command import text_of
from grip_bt.ros.process_group import Member, member_of
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.start import Start


def project_members(project: Project, names: Sequence[str] = ()) -> list[Member]:
    """Return the processes of a project; all of those that are to be run, where none is named.

    Raises:
        UnknownNameError, PackageError: there is no such process, package, program or launch file.
    """
    declared = project.file.processes
    for name in names:
        if name not in declared:
            raise UnknownNameError("process", name, declared, str(project.folder / "grip.yaml"))
    names = names or [name for name, config in declared.items() if config.run]
    return [member_of(name, declared[name], project.folder) for name in names]


def launch_file_of(project: Project, beside: Path) -> str:
    """Return the text of a launch file that starts what `grip launch` and a run start, and nothing else.

    Folders are written relative to the argument `project`, and that to the folder in which the file will be. What is
    declared with `run: false` is left out. Static frames of sensors need tf2_ros, which the wheels don't have: they
    are under the argument `frames`, off by default.

    Raises:
        DocumentError: a component file is wrong.
    """
    here, sensors = "$(var project)", project.file.sensors.items()
    starts: list[tuple[str, Start | None, str]] = [
        (name, process, f"{here}/{process.folder}" if process.folder else here)
        for name, process in project.file.processes.items()
    ]
    for name, home in project.component_folders().items():
        starts.append((name, load_component(home).start, f"{here}/{home.relative_to(project.folder)}"))
    starts += [(f"{name}_driver", sensor.driver, here) for name, sensor in sensors]
    jinja = Environment(trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True, finalize=_in_xml)
    return jinja.from_string(Path(__file__).with_name("launch.xml.j2").read_text(encoding="utf-8")).render(
        home=Path("$(dirname)", os.path.relpath(project.folder, beside.resolve())),
        starts=[each for each in starts if each[1] is not None],
        mounts=[(name, sensor.mount) for name, sensor in sensors if sensor.mount is not None],
        literal=_literal,
        text_of=text_of,
        words=lambda words: " ".join("$(var python)" if w == "{python}" else shlex.quote(_literal(w)) for w in words),
    )


def _in_xml(value: object) -> str:
    return escape(str(value), {'"': "&quot;"})


def _literal(text: str) -> str:
    """Return a text in which launch sees no substitution."""
    return text.replace("\\", "\\\\").replace("$", "\\$")
