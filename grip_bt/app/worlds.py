"""The worlds that can be simulated, and whether what a project says of its own is there: known without starting one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError, UnknownNameError

from .project import Project

WORLDS = ("table",)
_rooms: dict[Path, tuple[tuple[int, int] | None, DocumentError | None]] = {}
"""`.scene` files -> when they were written and how large they were, and what is wrong with them."""


def check_world(project: Project) -> None:
    """Verify the project's world, and the cameras that its sensors name, before anything is started for it.

    Raises:
        UnknownNameError: there is no such world or camera, or none is named; it lists those that there are.
        DocumentError: the file of the room can't be read.
    """
    if project.file.world is None:
        raise UnknownNameError("world", "", WORLDS, "grip.yaml: world")
    for fault in faults_of_world(project):
        raise fault
    check_cameras(project)


def check_cameras(project: Project, world: str | None = None) -> None:
    """Verify the cameras that a project's sensors name, in its own world or in another.

    Raises:
        UnknownNameError: there is no such camera.
    """
    for name in project.file.sensors:
        for fault in faults_of_camera(project, name, world):
            raise fault


def faults_of_world(project: Project) -> Iterator[GripError]:
    """Yield what is wrong with `world:` and `scene:`; nothing of those that the project doesn't have."""
    world = project.file.world
    if world is not None and world not in WORLDS:
        yield UnknownNameError("world", world, WORLDS, "grip.yaml: world")
    error = None if project.file.scene is None else _fault_of_room(project.folder / project.file.scene)
    if error is not None:
        yield error


def faults_of_camera(project: Project, sensor: str, world: str | None = None) -> Iterator[UnknownNameError]:
    """Yield that a world has no such camera as a sensor names.

    Nothing is said where no world is named, or an unknown one, or where the simulator isn't installed: a camera of the
    robot itself is known by the sensor's name, and needs no world.

    Args:
        project: with the sensor.
        sensor: its name.
        world: which world; the project's own where it isn't given.
    """
    camera, world = project.file.sensors[sensor].camera, world or project.file.world
    cameras = None if camera is None or world is None else cameras_of(world)
    if camera is not None and cameras is not None and camera not in cameras:
        yield UnknownNameError("camera", camera, cameras, f"grip.yaml: sensors/{sensor}/camera, world {world!r}")


def _fault_of_room(file: Path) -> DocumentError | None:
    """Return what is wrong with a `.scene` file; one with meshes is large, so it is read again when it has changed."""
    from grip_bt.commanders.scene_file import load_scene

    try:
        there = file.stat()
        stamp = there.st_mtime_ns, there.st_size
    except OSError:
        stamp = None
    if file not in _rooms or _rooms[file][0] != stamp:
        try:
            load_scene(file)
            fault = None
        except DocumentError as error:
            fault = error
        _rooms[file] = stamp, fault
    return _rooms[file][1]


def cameras_of(world: str) -> tuple[str, ...] | None:
    """Return the names of a world's cameras; None where nobody knows."""
    if world not in WORLDS:
        return None
    try:
        from grip_sim.specs import WorldSpec
    except ImportError:
        return None
    return tuple(camera.name for camera in WorldSpec().cameras)
