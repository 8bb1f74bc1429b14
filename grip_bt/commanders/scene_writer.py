"""Scenes as `.scene` files, in the form that MoveIt writes now; `scene_file` reads them."""

from __future__ import annotations

from collections.abc import Iterable

from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, Cylinder, Mesh, Solid, Sphere

from .scene import SceneObject


def scene_text(name: str, objects: Iterable[SceneObject]) -> str:
    """Return objects as the text of a `.scene` file; each has one shape, at its own origin.

    Raises:
        ValueError: a shape isn't a box, a sphere, a cylinder or a mesh of triangles, or an object is in a hand.
    """
    lines = [name]
    for item in objects:
        if item.hand:
            raise ValueError(f"{item.name} is held by {item.hand}: a .scene file has objects of the room only")
        lines += [f"* {item.name}", *_pose(item.pose), "1", *_shape(item), *_pose(Pose()), "0 0 0 0", "0"]
    return "\n".join([*lines, "."]) + "\n"


def _shape(item: SceneObject) -> list[str]:
    shape: Solid = item.shape
    if isinstance(shape, Box):
        return ["box", _row(shape.size)]
    if isinstance(shape, Sphere):
        return ["sphere", _row([shape.radius])]
    if isinstance(shape, Cylinder):
        return ["cylinder", _row([shape.radius, shape.height])]
    if isinstance(shape, Mesh) and len(shape.triangles):
        counts = f"{len(shape.points)} {len(shape.triangles)}"
        return ["mesh", counts, *map(_row, shape.points.tolist()), *(f"{a} {b} {c}" for a, b, c in shape.triangles)]
    raise ValueError(f"{item.name}: a {type(shape).__name__} can't be written into a .scene file")


def _pose(pose: Pose) -> list[str]:
    w, x, y, z = pose.quaternion
    return [_row(pose.position), _row([x, y, z, w])]


def _row(numbers: Iterable[float]) -> str:
    return " ".join(f"{float(number):.9g}" for number in numbers)
