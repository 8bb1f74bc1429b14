"""Leaves that change the planning scene by hand: shapes, meshes, clouds, files, attachments, allowed contacts."""

from __future__ import annotations

from collections.abc import Callable
from fnmatch import fnmatchcase
from typing import TypeVar

from grip_bt.base.errors import DocumentError, UnknownNameError, listing, plural
from grip_bt.base.failures import BadFileError, NoObjectError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Scene
from grip_bt.base.values import PointCloud, Pose
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Solid, Sphere

from .hand import HandLeaf
from .leaf import Leaf, OperationLeaf, Status

T = TypeVar("T")
SHAPES: dict[str, tuple[int, type]] = {"box": (3, Box), "cylinder": (2, Cylinder), "sphere": (1, Sphere)}
"""Shape -> how many lengths it has, and its class."""


class _SceneLeaf(Leaf):
    """A leaf that changes the scene at once; names that it doesn't have, or mustn't change, are failures."""

    def update(self) -> Status:
        try:
            return self.change(self.context.scene())
        except NoObjectError as error:
            return self.fail(error.code, error.message, **error.data)

    def change(self, scene: Scene) -> Status:
        raise NotImplementedError


def _free_to_change(scene: Scene, name: str) -> None:
    if scene.fixed(name):
        raise NoObjectError(f"{name!r} belongs to the room and can't be changed", objects=_movable(scene))


def _known_object(scene: Scene, name: str) -> None:
    if name not in scene.names():
        there = listing(sorted(scene.names()))
        raise NoObjectError(f"the scene has no object {name!r} (available: {there})", objects=sorted(scene.names()))


def _movable(scene: Scene) -> list[str]:
    return sorted(name for name in scene.names() if not scene.fixed(name))


class AddShape(_SceneLeaf):
    """Add a box, a cylinder or a sphere."""

    def prepare(self) -> None:
        kind, size = self.params["shape"], self.params["size"]
        if kind not in SHAPES:
            raise UnknownNameError("shape", kind, SHAPES, where=self.path)
        count, make = SHAPES[kind]
        if len(size) != count:
            raise ValueError(f"{self.path}: a {kind} has {plural(count, 'length')} [m], not {size}")
        self._solid: Solid = make(tuple(size)) if kind == "box" else make(*size)

    def change(self, scene: Scene) -> Status:
        name = self.params["name"]
        _free_to_change(scene, name)
        pose: Pose | None = self.read("pose")
        scene.put(name, self._solid, Pose(self.params["position"]) if pose is None else pose)
        return self.end()


class AddMesh(OperationLeaf):
    """Add a mesh from a file."""

    def start(self) -> Operation[Solid]:
        scene, p = self.context.scene(), self.params
        _free_to_change(scene, p["name"])
        return self.context.run_in_worker(lambda: _expected(lambda: scene.mesh(p["file"], p["scale"], p["hollow"])))

    def finish(self, result: Solid) -> Status:
        pose: Pose | None = self.read("pose")
        place = Pose(self.params["position"]) if pose is None else pose
        self.context.scene().put(self.params["name"], result, place)
        return self.end()


class AddCloud(OperationLeaf):
    """Avoid whatever a cloud shows, as a map of occupied cells."""

    def start(self) -> Operation[Solid]:
        cloud: PointCloud = self.read("cloud")
        if cloud.frame != "world":
            raise SensorError(f"the cloud is given in frame {cloud.frame!r}, not in world")
        return self.context.run_in_worker(lambda: self._cells(cloud))

    def finish(self, result: CellMap) -> Status:
        self.context.scene().put(self.params["name"], result, Pose())
        return self.end(cells=len(result.cells))

    def _cells(self, cloud: PointCloud) -> CellMap:
        p = self.params
        points = cloud.points[cloud.points[:, 2] >= p["min_height"]]
        try:
            return CellMap.of_points(points, p["resolution"], p["min_points"])
        except ValueError as error:
            raise SensorError(
                f"no cell of {p['resolution']:g} m holds {p['min_points']} of the {len(points)} points from "
                f"{p['min_height']:g} m up: the cloud shows nothing there, or it is thinner than `resolution` and "
                "`min_points` ask for"
            ) from error


class Load(OperationLeaf):
    """Add the objects of a `.scene` file."""

    def start(self) -> Operation[tuple[str, ...]]:
        scene = self.context.scene()
        return self.context.run_in_worker(lambda: _expected(lambda: scene.load(self.params["file"])))

    def finish(self, result: tuple[str, ...]) -> Status:
        return self.end(names=list(result))


class Remove(_SceneLeaf):
    """Take objects out of the scene."""

    def change(self, scene: Scene) -> Status:
        """Remove what the pattern names; a plain name that isn't there is a failure."""
        pattern = self.params["name"]
        names = [name for name in _movable(scene) if fnmatchcase(name, pattern)]
        if not names and not any(c in pattern for c in "*?["):
            _known_object(scene, pattern)
            _free_to_change(scene, pattern)
        for name in names:
            scene.remove(name)
        return self.end(count=len(names))


class Attach(HandLeaf, _SceneLeaf):
    """Have an object move with a hand."""

    def change(self, scene: Scene) -> Status:
        name = self.params["name"]
        _known_object(scene, name)
        _free_to_change(scene, name)
        scene.attach(name, self.hand.name)
        return self.end()

    def update(self) -> Status:
        return _SceneLeaf.update(self)


class Detach(_SceneLeaf):
    """Have an object stay where it is."""

    def change(self, scene: Scene) -> Status:
        _known_object(scene, self.params["name"])
        scene.detach(self.params["name"])
        return self.end()


class AllowCollisions(_SceneLeaf):
    """Allow contact of two names, or forbid it again."""

    def change(self, scene: Scene) -> Status:
        try:
            scene.allow(self.params["one"], self.params["other"], self.params["allowed"])
        except UnknownNameError as error:
            raise NoObjectError(str(error), objects=list(error.allowed)) from error
        return self.end()


class Snapshot(Leaf):
    """Hand out the scene as it is now."""

    def update(self) -> Status:
        return self.end(snapshot=self.context.scene().snapshot())


class Restore(Leaf):
    """Go back to an earlier state of the scene."""

    def update(self) -> Status:
        self.context.scene().restore(self.read("snapshot"))
        return self.end()


def _expected(read: Callable[[], T]) -> T:
    """Read a file; that it is wrong, or names what isn't there, is a failure of the task: it may come from one."""
    try:
        return read()
    except (DocumentError, UnknownNameError, ValueError) as error:
        raise BadFileError(str(error)) from error
