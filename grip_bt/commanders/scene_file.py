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

from collections.abc import Callable, Iterable
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
    objects: dict[str, SceneObject] = {}
    while (mark := reader.word("`*` before an object, or `.` at the end")) != ".":
        if mark != "*":
            raise reader.fault(f"an object begins with `*`, and the file ends with `.`; there is {mark!r}")
        name = reader.word("a name")
        if not name or name in objects:
            raise reader.fault(f"there are two objects {name!r}" if name else "an object needs a name after `*`")
        for item in _shapes(reader, name):
            objects[item.name] = item
    return tuple(objects.values())


def _shapes(reader: _Reader, name: str) -> list[SceneObject]:
    at = reader.pose() if reader.new_form else Pose()
    made = []
    for k in range(reader.count("the number of shapes")):
        kind = reader.word("a shape")
        if kind not in _KINDS:
            known = f"{nearest(kind, _KINDS)} (available: {listing(sorted(_KINDS))})"
            raise reader.fault(f"object {name!r}: unknown shape {kind!r}{known}")
        try:
            solid = _KINDS[kind](reader)
        except ValueError as error:
            raise reader.fault(f"object {name!r}: {error}") from None
        pose = at @ reader.pose()
        reader.numbers(4, "a colour")
        made.append(SceneObject(name if k == 0 else f"{name}.{k + 1}", solid, pose))
    if reader.new_form:
        for _ in range(reader.count("the number of subframes")):
            reader.word("a subframe's name")
            reader.pose()
    return made


class _Reader:
    """Words of a text, and where they stand.

    Attributes:
        new_form: whether numbers stand below the first object's name: the object's pose.
    """

    def __init__(self, text: str, source: str):
        lines, self._source, self._row = text.splitlines()[1:], source, 1
        marks = [k + 1 for k, line in enumerate(lines) if line.startswith("*")]
        self.new_form = not marks or " " in (lines[marks[0]].strip() if marks[0] < len(lines) else "")
        self._words = (
            (row, word)
            for row, line in enumerate(lines, start=2)
            for word in (["*", " ".join(line[1:].split())] if line.startswith("*") else line.split())
        )

    def word(self, what: str) -> str:
        """Return the next word; of an object's name, all of it."""
        self._row, word = next(self._words, (self._row, ""))
        if not word and what != "a name":
            raise self.fault(f"the file ends where {what} is expected")
        return word

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
        return DocumentError(message, self._source, self._row)

    def _number(self, word: str, what: str) -> float:
        try:
            number = float(word)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            raise self.fault(f"{what} is expected; {word!r} isn't a number")
        return number


def _mesh(reader: _Reader) -> Solid:
    """A mesh keeps its surface: a scene's meshes are often hollow."""
    points, triangles = reader.count("a mesh's number of points"), reader.count("its number of triangles")
    if not triangles:
        raise ValueError("a mesh has triangles")
    rows = np.array(reader.numbers(3 * points, "a point of a mesh")).reshape(-1, 3)
    faces = np.array([reader.count("an index of a point") for _ in range(3 * triangles)], np.int32)
    return Mesh(rows, faces.reshape(-1, 3))


_KINDS: dict[str, Callable[[_Reader], Solid]] = {
    "box": lambda reader: Box(tuple(reader.numbers(3, "a box's edge lengths"))),  # type: ignore[arg-type]
    "cylinder": lambda reader: Cylinder(*reader.numbers(2, "a cylinder's radius and height")),
    "mesh": _mesh,
    "sphere": lambda reader: Sphere(*reader.numbers(1, "a sphere's radius")),
}
