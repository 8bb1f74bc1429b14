"""Shapes of the planning scene: what is checked is what was said, for every kind of shape."""

from __future__ import annotations

import numpy as np
import pytest
from table_top import named, robot_model

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Mesh, Sphere
from grip_bt.commanders.description.tree import joints_of_fingers, limits_of_joints, links_of_groups
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.shapes import hull_of, load_mesh
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot

CUBE = np.array([(x, y, z) for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)])
SIDES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4)]
FILLED = np.stack(np.meshgrid(*[np.arange(-0.045, 0.05, 0.01)] * 3), axis=-1).reshape(-1, 3)
SOLIDS = {
    "box": Box((0.1, 0.1, 0.1)),
    "cylinder": Cylinder(0.05, 0.1),
    "sphere": Sphere(0.05),
    "hull": Mesh(CUBE),
    "surface": Mesh(CUBE, SIDES),
    "cells": CellMap.of_points(FILLED, 0.01),
}
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def checker(solid, pose, margin=0.0, allowed=()):
    model = robot_model()
    chain = model.chain("arm", named(model, "arm", "home"))
    scene = SceneSnapshot({"thing": SceneObject("thing", solid, pose)}, frozenset(allowed))
    return CollisionChecker(chain, scene, "hand", margin)


def home():
    return named(robot_model(), "arm", "home").position


def palm():
    return robot_model().grasp_pose(named(robot_model(), "arm", "home"))


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_shape_is_touched_where_it_is_and_not_elsewhere(kind):
    assert not checker(SOLIDS[kind], palm()).free(home())
    assert checker(SOLIDS[kind], palm().moved((0.0, 0.0, 0.5))).free(home())


@pytest.mark.parametrize("kind", SOLIDS)
def test_all_shapes_of_one_size_tell_the_same_bounding_box(kind):
    assert SOLIDS[kind].extents() == pytest.approx((0.1, 0.1, 0.1))
    assert SOLIDS[kind].centre() == pytest.approx((0.0, 0.0, 0.0))


@pytest.mark.parametrize("kind", [kind for kind in SOLIDS if kind != "surface"])
def test_a_margin_keeps_the_robot_that_far_away(kind):
    """Go up from the hand until the shape is free: with a margin that takes at least so much longer."""

    def first_free(margin):
        heights = np.arange(0.0, 0.4, 0.005)
        return next(h for h in heights if checker(SOLIDS[kind], palm().moved((0, 0, h)), margin).free(home()))

    assert first_free(0.03) - first_free(0.0) >= 0.03 - 0.0051


@pytest.mark.parametrize("kind", [kind for kind in SOLIDS if kind not in ("surface", "cells")])
def test_a_shape_shrinks_on_every_side_and_never_to_nothing(kind):
    assert SOLIDS[kind].grown(-0.01).extents() == pytest.approx((0.08, 0.08, 0.08))
    assert all(length > 0 for length in SOLIDS[kind].grown(-1.0).extents())


def test_the_inside_of_a_hollow_mesh_is_free_and_that_of_its_hull_is_not():
    big, around = 10 * CUBE, Pose(palm().position)
    surface = Mesh(big, SIDES)
    touching = {
        pair for pair in checker(surface, around).pairs(home()) if "finger" in pair[0] or "hand_link" in pair[0]
    }
    assert not touching
    assert any("hand_link" in pair[0] for pair in checker(Mesh(big), around).pairs(home()))


def test_a_hull_keeps_only_its_corners_and_means_the_same():
    inner = np.random.default_rng(0).uniform(-0.05, 0.05, (500, 3))
    hull = hull_of(Mesh(np.vstack([CUBE, inner])))
    assert sorted(map(tuple, hull.points)) == sorted(map(tuple, CUBE))


def test_cells_hold_every_point_that_made_them_and_noise_is_left_out():
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (2000, 3))
    made = CellMap.of_points(points, 0.05)
    nearest = np.abs(points[:, None] - made.middles()).max(axis=2).min(axis=1)
    assert nearest.max() <= 0.025 + 1e-9
    assert len(CellMap.of_points([*points, *[points[0]] * 5], 0.05, min_points=5).cells) == 1
    with pytest.raises(ValueError, match="at least one"):
        CellMap.of_points(np.full((3, 3), np.nan), 0.05)


def test_grown_cells_reach_every_neighbour_within_the_margin():
    grown = CellMap(np.zeros((1, 3)), 0.02).grown(0.03)
    assert len(grown.cells) == 5**3
    assert grown.extents() == pytest.approx((0.1, 0.1, 0.1))


def test_allowing_a_hand_to_touch_a_thing_lets_it_and_forbidding_it_is_heeded_again():
    model = robot_model()
    links = links_of_groups(model.description, {"arm": "arm", "right_hand": "hand"})
    scene = PlanningScene({"right_hand": palm}, links=links)
    scene.put("thing", Sphere(0.05), palm().moved(palm().rotation() @ (0, 0, 0.05)))
    chain = model.chain("arm", named(model, "arm", "home"))

    def touching():
        return {one for one, _ in CollisionChecker(chain, scene.snapshot(), "right_hand").pairs(home())}

    before = touching()
    assert before
    scene.allow("right_hand", "thing")
    assert not touching() & set(links["right_hand"])
    scene.allow("thing", "*")
    assert not touching()
    scene.allow("*", "thing", allowed=False)
    scene.allow("thing", "right_hand", allowed=False)
    assert touching() == before
    with pytest.raises(UnknownNameError, match="'thing'"):
        scene.allow("thnig", "*")


def test_an_arms_links_end_where_the_hands_begin():
    links = links_of_groups(robot_model().description, {"arm": "arm", "hand": "hand"})
    assert "panda_link7" in links["arm"]
    assert not set(links["arm"]) & set(links["hand"])
    assert len(links["hand"]) >= 16


def test_each_finger_has_its_joints_and_each_joint_its_limits():
    robot = robot_model().description
    fingers = joints_of_fingers(robot, "hand")
    assert set(fingers) == {"index", "middle", "ring", "thumb"}
    assert [len(joints) for joints in fingers.values()] == [4, 4, 4, 4]
    assert {joint for joints in fingers.values() for joint in joints} == set(robot.group("hand"))
    limits, wanted = limits_of_joints(robot, "hand"), robot_model().limits("hand")
    for name, low, high in zip(robot.group("hand"), wanted.lower, wanted.upper, strict=True):
        assert limits[name] == pytest.approx((low, high))


def test_a_mesh_file_becomes_a_hull_or_a_surface_in_the_wanted_scale(tmp_path):
    (tmp_path / "corner.obj").write_text(OBJ)
    hull = load_mesh("corner.obj", (0.1, 0.1, 0.2), folder=tmp_path)
    assert hull.extents() == pytest.approx((0.1, 0.1, 0.2))
    assert hull.centre() == pytest.approx((0.05, 0.05, 0.1))
    surface = load_mesh("package://things/corner.obj", hollow=True, packages={"things": tmp_path})
    assert surface.triangles.shape == (4, 3)


@pytest.mark.parametrize(
    ("name", "says"), [("no.obj", "no such"), ("bad.stl", "mesh"), ("bad.txt", "dae, obj, ply, stl")]
)
def test_what_is_no_mesh_file_says_so(tmp_path, name, says):
    if name.startswith("bad"):
        (tmp_path / name).write_text("rubbish")
    with pytest.raises(DocumentError, match=says):
        load_mesh(name, folder=tmp_path)


def test_an_unknown_package_lists_those_that_are_known(tmp_path):
    with pytest.raises(DocumentError, match="given: things"):
        load_mesh("package://thigns/corner.obj", packages={"things": tmp_path})


def test_a_snapshot_brings_back_objects_attachments_and_allowed_contacts():
    scene = PlanningScene({"hand": lambda: Pose()})
    scene.put("ball", Sphere(0.03), Pose((0.1, 0.0, 0.0)))
    scene.attach("ball", "hand")
    scene.allow("ball", "table")
    before = scene.snapshot()
    scene.detach("ball")
    scene.remove("ball")
    scene.allow("ball", "table", allowed=False)
    scene.restore(before)
    assert scene.attached("hand") == ("ball",)
    assert scene.snapshot() == before
    with pytest.raises(TypeError, match="snapshot"):
        scene.restore("before")
