"""Scenes as `.scene` files, in the form that MoveIt writes now and in its old one.

(noname)+
    * table
    0.6 0 -0.05        the object's pose: new form only
    0 0 0 1
    1                  how many shapes
    box
    0.7 1.2 0.1
    0 0 0              each shape's pose, in the object (new form) or in world (old)
    0 0 0 1
    0 0 0 0            its colour, which nothing here needs
    0                  how many subframes: new form only
    .

Quaternions are x y z w there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, Cylinder, Mesh, Solid, Sphere

from .scene_state import SceneObject


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


_SIDES = 32
_SLAB = (10.0, 0.1)
"""A plane becomes a slab so wide and so thick [m], below it."""
_MOST = 1_000_000


def load_scene(file: str | Path) -> tuple[SceneObject, ...]:
    """Read a `.scene` file; an object of several shapes becomes several objects, `name`, `name.2` and so on.

    Raises:
        DocumentError: it isn't one; the error says in which line.
    """
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else f"it isn't UTF-8 text ({error})"
        raise DocumentError(f"can't be read: {reason}", str(file)) from None
    return parse_scene(text, str(file))


def parse_scene(text: str, source: str = "") -> tuple[SceneObject, ...]:
    """Read the text of a `.scene` file; see `load_scene`."""
    reader = _Reader(text, source)
    new_form = reader.is_new_form()
    reader.line()
    objects: dict[str, SceneObject] = {}
    while (mark := reader.word("`*` before an object, or `.` at the end")) != ".":
        if mark != "*":
            raise reader.fault(f"an object begins with `*`, and the file ends with `.`; there is {mark!r}")
        name = reader.line()
        if not name or name in objects:
            raise reader.fault(f"there are two objects {name!r}" if name else "an object needs a name after `*`")
        for item in _shapes(reader, name, new_form):
            objects[item.name] = item
    return tuple(objects.values())


def _shapes(reader: _Reader, name: str, new_form: bool) -> list[SceneObject]:
    at = reader.pose() if new_form else Pose()
    made = []
    for k in range(reader.count("the number of shapes")):
        kind = reader.word("a shape")
        if kind not in _KINDS:
            known = f"{nearest(kind, _KINDS)} (available: {listing(sorted(_KINDS))})"
            raise reader.fault(f"object {name!r}: unknown shape {kind!r}{known}")
        try:
            solid, inner = _KINDS[kind](reader)
        except ValueError as error:
            raise reader.fault(f"object {name!r}: {error}") from None
        pose = at @ reader.pose() @ inner
        reader.numbers(4, "a colour")
        made.append(SceneObject(name if k == 0 else f"{name}.{k + 1}", solid, pose))
    if new_form:
        for _ in range(reader.count("the number of subframes")):
            reader.word("a subframe's name")
            reader.pose()
    return made


class _Reader:
    """Words of a text, and where they stand."""

    def __init__(self, text: str, source: str):
        self._lines, self._source = text.splitlines(), source
        self._row = 0
        self._words: Iterator[str] = iter(())
        self._next_line()

    def is_new_form(self) -> bool:
        """Tell whether three numbers stand below the first object's name: the object's pose."""
        for row, line in enumerate(self._lines[1:], start=1):
            if line.startswith("*"):
                return row + 1 < len(self._lines) and " " in self._lines[row + 1].strip()
        return True

    def line(self) -> str:
        """Return the rest of the line."""
        rest = " ".join(self._words)
        self._next_line()
        return rest

    def word(self, what: str) -> str:
        """Return the next word."""
        while (word := next(self._words, None)) is None:
            if self._row >= len(self._lines):
                raise self.fault(f"the file ends where {what} is expected")
            self._next_line()
        return str(word)

    def numbers(self, count: int, what: str) -> list[float]:
        """Return the next numbers."""
        return [self._number(self.word(what), what) for _ in range(count)]

    def count(self, what: str) -> int:
        """Return the next whole number."""
        word = self.word(what)
        if not word.isdecimal() or int(word) > _MOST:
            raise self.fault(f"{what} is a whole number up to {_MOST}, not {word!r}")
        return int(word)

    def pose(self) -> Pose:
        """Return the next position and quaternion."""
        x, y, z, qx, qy, qz, qw = self.numbers(7, "a pose: x y z, then qx qy qz qw")
        try:
            return Pose((x, y, z), (qw, qx, qy, qz))
        except ValueError as error:
            raise self.fault(str(error)) from None

    def fault(self, message: str) -> DocumentError:
        """Return an error at the present line."""
        return DocumentError(message, self._source, max(self._row, 1))

    def _number(self, word: str, what: str) -> float:
        try:
            number = float(word)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            raise self.fault(f"{what} is expected; {word!r} isn't a number")
        return number

    def _next_line(self) -> None:
        words = self._lines[self._row].split() if self._row < len(self._lines) else []
        self._row += 1
        self._words = iter(words)


def _cone(reader: _Reader) -> tuple[Solid, Pose]:
    """A cone about z, its middle at half its height, becomes the pyramid of 32 sides around it."""
    radius, height = reader.numbers(2, "a cone's radius and height")
    turn = np.arange(_SIDES) * 2 * np.pi / _SIDES
    rim = radius / np.cos(np.pi / _SIDES) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    foot = np.column_stack([rim, np.full(_SIDES, -height / 2)])
    return Mesh(np.vstack([foot, [[0.0, 0.0, height / 2]]])), Pose()


def _plane(reader: _Reader) -> tuple[Solid, Pose]:
    """A plane a x + b y + c z + d = 0 becomes a slab on the side that its normal turns its back to."""
    plane = np.array(reader.numbers(4, "a plane's a b c d"))
    length = float(np.linalg.norm(plane[:3]))
    if length < 1e-9:
        raise ValueError("a plane needs a normal that isn't zero")
    normal, offset = plane[:3] / length, -plane[3] / length
    side = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    side /= np.linalg.norm(side)
    at = np.eye(4)
    at[:3, :3] = np.stack([side, np.cross(normal, side), normal], axis=1)
    at[:3, 3] = normal * (offset - _SLAB[1] / 2)
    return Box((_SLAB[0], _SLAB[0], _SLAB[1])), Pose.from_matrix(at)


def _mesh(reader: _Reader) -> tuple[Solid, Pose]:
    """A mesh keeps its surface: a scene's meshes are often hollow."""
    points, triangles = reader.count("a mesh's number of points"), reader.count("its number of triangles")
    if not triangles:
        raise ValueError("a mesh has triangles")
    rows = np.array(reader.numbers(3 * points, "a point of a mesh")).reshape(-1, 3)
    faces = np.array([reader.count("an index of a point") for _ in range(3 * triangles)], np.int32)
    return Mesh(rows, faces.reshape(-1, 3)), Pose()


_KINDS: dict[str, Callable[[_Reader], tuple[Solid, Pose]]] = {
    "box": lambda reader: (Box(tuple(reader.numbers(3, "a box's edge lengths"))), Pose()),  # type: ignore[arg-type]
    "cone": _cone,
    "cylinder": lambda reader: (Cylinder(*reader.numbers(2, "a cylinder's radius and height")), Pose()),
    "mesh": _mesh,
    "plane": _plane,
    "sphere": lambda reader: (Sphere(*reader.numbers(1, "a sphere's radius")), Pose()),
}
