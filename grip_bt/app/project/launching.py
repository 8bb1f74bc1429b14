"""The processes of a project, from `grip.yaml` to a group that runs."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from grip_bt.app.project.folder import Project
from grip_bt.base.errors import UnknownNameError
from grip_bt.ros.launch.group import Member
from grip_bt.ros.process import child_environment, command_of, text_of
from grip_bt.task.catalog.component_file import ProcessConfig, Start, load_component


def project_members(project: Project, names: Sequence[str] = ()) -> list[Member]:
    """Return the processes of a project; all of those that are to be run, where none is named.

    Raises:
        UnknownNameError, PackageError: there is no such process, package, program or launch file.
    """
    declared = project.file.processes
    for name in names:
        if name not in declared:
            raise UnknownNameError("process", name, declared, str(project.folder / "grip.yaml"))
    members = []
    for name in names or [name for name, config in declared.items() if config.run]:
        config, folder = declared[name], project.folder
        environment = child_environment(more=config.env)
        again = (config.ready, config.restart, config.restarts, config.restart_delay, config.required)
        members.append(Member(name, command_of(config, folder), folder / (config.folder or "."), environment, *again))
    return members


HEAD = '<?xml version="1.0"?>\n'


def launch_file_of(project: Project, beside: Path) -> str:
    """Return the text of a launch file that starts what `grip launch` and a run start, and nothing else.

    Folders are written relative to the argument `project`, and that to the folder in which the file will be. What is
    declared with `run: false` is left out. Static frames of sensors need tf2_ros, which the wheels don't have: they
    are under the argument `frames`, off by default.

    Raises:
        DocumentError: a component file is wrong.
    """
    root = ElementTree.Element("launch")
    home = Path("$(dirname)", os.path.relpath(project.folder, beside.resolve()))
    _add(root, "arg", name="project", default=str(home), description="folder of the project")
    _add(root, "arg", name="python", default="python3", description="the Python that has grip-bt")
    _add(root, "arg", name="frames", default="false", description="publish the frames of sensors; needs tf2_ros")
    for name, process in project.file.processes.items():
        _start(root, name, process, "$(var project)" + (f"/{process.folder}" if process.folder else ""), process)
    for name, home in project.component_folders().items():
        component = load_component(home)
        if component.start is not None:
            _start(root, name, component.start, f"$(var project)/{home.relative_to(project.folder)}")
    for name, sensor in project.file.sensors.items():
        if sensor.driver is not None:
            _start(root, f"{name}_driver", sensor.driver, "$(var project)")
        if sensor.mount is not None:
            x, y, z = map(str, sensor.mount.position)
            qw, qx, qy, qz = map(str, sensor.mount.quaternion)
            words = ["--x", x, "--y", y, "--z", z, "--qx", qx, "--qy", qy, "--qz", qz, "--qw", qw]
            words += ["--frame-id", sensor.mount.on, "--child-frame-id", sensor.mount.frame]
            attributes = {"pkg": "tf2_ros", "exec": "static_transform_publisher", "name": f"{name}_frame"}
            _add(root, "node", **attributes, args=shlex.join(words), **{"if": "$(var frames)"})
    ElementTree.indent(root)
    return HEAD + ElementTree.tostring(root, encoding="unicode") + "\n"


def _start(
    root: ElementTree.Element, name: str, start: Start, folder: str, process: ProcessConfig | None = None
) -> None:
    if not start.run:
        return
    if start.launch is not None:
        _include(root, start, folder)
        return
    common = {"name": name, "output": "both", "cwd": folder}
    if process is not None and process.restart == "always":
        common |= {"respawn": "true", "respawn_delay": str(process.restart_delay)}
    if process is not None and process.required and process.restart == "never":
        common["on_exit"] = "shutdown"
    if start.executable is not None:
        words = shlex.join(map(_literal, start.args))
        extra = {"args": words} if words else {}
        element = _add(root, "node", pkg=str(start.package), exec=start.executable, **extra, **common)
    else:
        quoted = [shlex.quote(_literal(w)) if w != "{python}" else w for w in start.command]
        command = " ".join(quoted).replace("{python}", "$(var python)")  # an argument of the launch file
        element = _add(root, "executable", cmd=command, **common)
    for variable, value in start.env.items():
        _add(element, "env", name=variable, value=_literal(value))


def _include(root: ElementTree.Element, start: Start, folder: str) -> None:
    if start.package is not None:
        file = f"$(find-pkg-share {start.package})/launch/{start.launch}"
    else:
        file = str(start.launch) if Path(str(start.launch)).is_absolute() else f"{folder}/{start.launch}"
    group = _add(root, "group")
    for variable, value in start.env.items():
        _add(group, "set_env", name=variable, value=_literal(value))
    include = _add(group, "include", file=file)
    for argument, given in start.arguments.items():
        _add(include, "arg", name=argument, value=_literal(text_of(given)))


def _literal(text: str) -> str:
    """Return a text in which launch sees no substitution."""
    return text.replace("\\", "\\\\").replace("$", "\\$")


def _add(parent: ElementTree.Element, tag: str, /, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, tag, attributes)
