"""`.scene` files: both forms, every shape, and what is wrong with a file is said with its line."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, Cylinder, Mesh, Sphere
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.scene_file import load_scene, parse_scene

NEW = """(noname)+
* table top
1 0 0.5
0 0 0.70710678 0.70710678
2
box
0.2 0.4 0.1
0.1 0 0
0 0 0 1
0.5 0.5 0.5 1
sphere
0.05
0 0 0.1
0 0 0 1
0 0 0 0
1
handle
0 0 0.1
0 0 0 1
* can
0 0 0
0 0 0 1
1
cylinder
0.03 0.12
0.3 0 0.06
0 0 0 1
0 0 0 0
0
.
"""
OLD = """(noname)+
* can
1
cylinder
0.03 0.12
0.3 0 0.06
0 0 0 1
0 0 0 0
* shelf
1
mesh
4 2
0 0 0
1 0 0
0 1 0
0 0 1
0 1 2
0 1 3
0.5 0 0
0 0 0 1
0 0 0 0
.
"""


def test_the_new_form_puts_shapes_into_their_objects_pose():
    table, ball, can = parse_scene(NEW)
    assert [o.name for o in (table, ball, can)] == ["table top", "table top.2", "can"]
    assert table.shape == Box((0.2, 0.4, 0.1))
    assert table.pose.position == pytest.approx([1.0, 0.1, 0.5])
    assert table.pose.rotation() @ [1, 0, 0] == pytest.approx([0, 1, 0], abs=1e-6)
    assert ball.shape == Sphere(0.05)
    assert ball.pose.position == pytest.approx([1, 0, 0.6])
    assert can.shape == Cylinder(0.03, 0.12)
    assert can.pose.position == pytest.approx([0.3, 0, 0.06])


def test_the_old_form_puts_shapes_into_the_world():
    can, shelf = parse_scene(OLD)
    assert can.pose == Pose((0.3, 0, 0.06))
    assert isinstance(shelf.shape, Mesh)
    assert shelf.shape.hollow
    assert shelf.shape.triangles.tolist() == [[0, 1, 2], [0, 1, 3]]


@pytest.mark.parametrize(
    ("change", "line", "says"),
    [
        (("cylinder", "cilinder"), 24, "did you mean 'cylinder'"),
        (("cylinder", "cone"), 24, "unknown shape 'cone'.*available: box, cylinder, mesh, sphere"),
        (("0.03 0.12", "0.03 x"), 25, "'x' isn't a number"),
        (("0.03 0.12", "0.03 -0.12"), 25, "positive"),
        (("0.3 0 0.06\n0 0 0 1", "0.3 0 0.06\n0 0 0 0"), 27, "quaternion"),
        ((".\n", ""), 30, "file ends"),
        (("* can", "can"), 20, "begins with `\\*`"),
        (("* can", "*"), 20, "needs a name"),
        (("* can", "* table top"), 20, "two objects"),
        (("\n2\nbox", "\n99999999\nbox"), 5, "whole number up to"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(change, line, says):
    assert change[0] in NEW
    with pytest.raises(DocumentError, match=says) as caught:
        parse_scene(NEW.replace(*change, 1), "room.scene")
    assert abs(caught.value.line - line) <= 1


def test_no_text_at_all_is_refused_and_so_is_a_file_that_is_not_there(tmp_path):
    with pytest.raises(DocumentError, match="file ends"):
        parse_scene("")
    with pytest.raises(DocumentError, match="can't be read"):
        load_scene(tmp_path / "no.scene")
    (tmp_path / "binary.scene").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DocumentError, match="UTF-8"):
        load_scene(tmp_path / "binary.scene")


def test_mutated_files_are_read_or_refused_never_worse():
    rng = np.random.default_rng(0)
    for _ in range(300):
        text = list(rng.choice([NEW, OLD]))
        for _ in range(rng.integers(1, 8)):
            at = int(rng.integers(len(text)))
            text[at : at + int(rng.integers(0, 6))] = str(
                rng.choice(["", " ", "\n", "-1", "nan", "*", "1e999", "mesh"])
            )
        try:
            parse_scene("".join(text))
        except DocumentError:
            pass


def test_a_scene_loads_files_of_its_project(tmp_path):
    (tmp_path / "room.scene").write_text(NEW)
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "corner.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
    scene = PlanningScene({}, room=parse_scene(OLD), folder=tmp_path)
    with pytest.raises(ValueError, match="static object of the room"):
        scene.load("room.scene")  # its can has the name of the room's
    scene = PlanningScene({}, folder=tmp_path)
    assert scene.load("room.scene") == ("table top", "table top.2", "can")
    assert not scene.fixed("can")
    assert scene.mesh("package://parts/corner.obj").extents() == pytest.approx((1, 1, 1))
    assert scene.mesh("parts/corner.obj", (2, 1, 1), hollow=True).hollow
