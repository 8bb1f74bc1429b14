"""What the robot hides of a view, from its hulls; and the arm that goes where it hides nothing."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_perception_leaves import INFO, frame, thing

from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.commanders.scene import PlanningScene
from grip_bt.nodes.camera_views import outline, robot_pixels, share, within
from grip_bt.task.catalog.ros_config import sensor_manifest

ALL = np.ones((240, 320), dtype=bool)


def box(x, y, half, low, high):
    return np.array([[x + a * half, y + b * half, z] for a in (-1, 1) for b in (-1, 1) for z in (low, high)])


places = st.tuples(st.floats(0.3, 0.75), st.floats(-0.2, 0.45), st.floats(0.02, 0.08), st.floats(0.1, 0.6))


@given(st.lists(places, min_size=1, max_size=3))
def test_the_robots_pixels_are_those_that_show_it(boxes):
    """Each is drawn with a ray a pixel; outlines are drawn as polygons: at most their edges differ."""
    drawn = frame(*((x, y, half, half, top, (222, 222, 226)) for x, y, half, top in boxes))
    mine = robot_pixels(drawn.depth, [box(x, y, half, 0.0, top) for x, y, half, top in boxes])
    shown = (drawn.image.pixels == (222, 222, 226)).all(axis=2)
    assert not (shown & ~mine & ~_edges(shown)).any()


def _edges(mask):
    near = np.zeros_like(mask)
    for dy in (-2, -1, 0, 1, 2):
        for dx in (-2, -1, 0, 1, 2):
            near |= np.roll(~mask, (dy, dx), (0, 1))
    return near


def test_what_is_seen_through_a_hull_that_is_too_large_is_not_hidden():
    """A capsule's box has corners that aren't there: the camera sees the table through them."""
    table = frame()
    hull = [box(0.5, 0.1, 0.2, 0.5, 0.7)]
    assert outline(INFO, hull).any()
    assert not robot_pixels(table.depth, hull).any()


def test_a_thing_under_a_hull_is_not_taken_for_the_robot():
    assert not robot_pixels(frame(thing()).depth, [box(0.5, 0.1, 0.05, 0.3, 0.5)]).any()


def test_the_robot_behind_the_camera_hides_nothing_and_around_it_everything():
    x, y, z = INFO.pose.position
    assert not outline(INFO, [box(x, y, 0.1, z + 0.05, z + 0.3)]).any()
    assert outline(INFO, [box(x, y, 0.1, z - 0.2, z + 0.2)]).all()


def test_a_region_is_what_looks_at_it():
    region = within(INFO, (0.43, 0.63, 0.04, 0.24), 0.0)
    at = frame().depth.points()[region]
    assert np.abs(at[:, 0] - 0.53).max() < 0.105
    assert np.abs(at[:, 1] - 0.14).max() < 0.105
    assert within(INFO, (), 0.0).all()
    assert share(ALL, region) == 1.0
    assert share(region, np.zeros_like(region)) == 0.0


# --- leaves ---


def robot_over(world, hulls_of):
    world.scene = PlanningScene({"right_hand": lambda: world.arm.grasp_pose()}, robot=hulls_of)
    world.context._scene = world.scene
    capture = frame(*world.drawn) if getattr(world, "drawn", None) else frame()
    world.context.cameras["overhead"] = SimpleNamespace(info=lambda: INFO, capture=lambda: Operation.finished(capture))


def test_a_blocked_view_is_told_from_a_table_with_nothing_on_it(world, tick):
    world.drawn = [(0.53, -0.06, 0.2, 0.2, 0.5, (222, 222, 226))]
    robot_over(world, lambda at: [box(0.53, -0.06, 0.2, 0.3, 0.5)])
    leaf = world.leaf(sensor_manifest("overhead"))
    assert tick(leaf) == ("FAILURE", "failure", "view_blocked")
    assert 0.3 < world.data["hidden"] < 0.7
    assert "hides" in leaf.failure.message
    assert set(world.data) == {"hidden"}
    allowed = world.leaf(sensor_manifest("overhead"), max_hidden=0.7)
    assert tick(allowed) == ("SUCCESS", "success", None)
    assert world.data["points"].points[:, 2].max() < 0.05, "the robot's own points are left out"
    beside = world.leaf(sensor_manifest("overhead"), region=[0.4, 0.6, 0.3, 0.45])
    assert tick(beside) == ("SUCCESS", "success", None)
    assert world.data["hidden"] == 0.0


def test_a_region_has_four_numbers_in_order(world):
    world.context.cameras["overhead"] = SimpleNamespace()
    with pytest.raises(ValueError, match="x from, x to, y from, y to"):
        world.leaf(sensor_manifest("overhead"), region=[0.6, 0.4, 0.0, 0.1])


def test_the_named_state_is_taken_where_it_hides_nothing(world, tick):
    robot_over(world, lambda at: [])
    assert tick(world.leaf("arm/clear_view"))[0] == "SUCCESS"
    assert [argument.position.tolist() for verb, argument in world.arm.log if verb == "plan"] == [[0.0]]


def test_a_camera_of_which_nothing_is_known_yet_takes_a_frame_first(world, tick):
    """As one on topics, before its first capture."""
    robot_over(world, lambda at: [])
    seen, taken = world.context.cameras["overhead"], []

    def info():
        if not taken:
            raise SensorError("nothing was heard yet")
        return INFO

    def capture():
        taken.append(1)
        return seen.capture()

    world.context.cameras["overhead"] = SimpleNamespace(info=info, capture=capture)
    for _ in range(2):
        assert tick(world.leaf("arm/clear_view"))[0] == "SUCCESS"
    assert len(taken) == 1


def test_elsewhere_the_arm_turns_until_it_hides_little_enough(world, tick):
    """The robot is an arm over the table that turns away with its first joint; half a radian is enough."""
    robot_over(world, lambda at: [box(0.53, 0.14, 0.2, 0.3, 0.5)] if abs(at.position[0]) < 0.5 else [])
    assert tick(world.leaf("arm/clear_view"))[0] == "SUCCESS"
    gone = [argument.position[0] for verb, argument in world.arm.log if verb == "plan"]
    assert len(gone) == 1
    assert 0.5 <= abs(gone[0]) < 0.53


def test_an_arm_that_always_hides_the_view_stays_and_says_so(world, tick):
    robot_over(world, lambda at: [box(0.53, 0.14, 0.2, 0.3, 0.5)])
    leaf = world.leaf("arm/clear_view")
    assert tick(leaf) == ("FAILURE", "failure", "view_blocked")
    assert leaf.failure.data["hidden"] > 0.2
    assert world.arm.log == []
