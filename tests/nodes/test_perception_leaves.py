"""The image-difference check on rendered tops of things, and the capture leaf."""

from types import SimpleNamespace

import numpy as np
import pytest

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, DepthImage, Image, Pose, RgbdFrame
from grip_bt.task.catalog.ros_config import sensor_manifest

F = 536.0
INFO = CameraInfo(
    320, 240, [[F, 0, 160], [0, F, 120], [0, 0, 1]], Pose([0.53, 0.14, 1.30], [0.0, 0.5**0.5, -(0.5**0.5), 0])
)
WOOD = (176, 158, 130)
PLACE = (0.5, 0.1)


def frame(*things, info=INFO, noise=0, seed=0):
    """Render the table and upright boxes, each (x, y, half width x, half width y, height, colour)."""
    rays = info.rays() @ info.pose.rotation().T
    origin = info.pose.position
    depth = np.full(rays.shape[:2], origin[2])
    image = np.full((*rays.shape[:2], 3), WOOD, np.uint8)
    for x, y, half_x, half_y, height, colour in sorted(things, key=lambda t: t[4]):
        for level in np.linspace(0, height, 12):
            at = origin + rays * ((origin[2] - level) / -rays[..., 2])[..., None]
            hit = (abs(at[..., 0] - x) <= half_x) & (abs(at[..., 1] - y) <= half_y)
            depth[hit], image[hit] = origin[2] - level, colour
    if noise:
        shift = np.random.default_rng(seed).normal(0, noise, image.shape)
        image = np.clip(image + shift, 0, 255).astype(np.uint8)
    return RgbdFrame(Image(image), DepthImage(depth.astype(np.float32), info))


def thing(x=0.5, y=0.1, half=0.03, height=0.15, colour=(205, 60, 45)):
    return x, y, half, half, height, colour


OTHER = thing(0.6, 0.25, colour=(60, 150, 70))
BEFORE = frame(thing(), OTHER)


def judge(world, tick, grasp_at, after, before=BEFORE, **more):
    leaf = world.leaf("perception/image_difference", before=before, after=after, grasp=grasp_at(PLACE), **more)
    return (*tick(leaf), leaf)


def test_an_object_that_is_gone_is_held(world, tick, grasp_at):
    status, outcome, code, _ = judge(world, tick, grasp_at, frame(OTHER))
    assert (status, outcome, code) == ("SUCCESS", "success", None)
    assert world.data["fraction"] > 0.9


def test_it_holds_with_camera_noise_too(world, tick, grasp_at):
    before, after = frame(thing(), OTHER, noise=5, seed=1), frame(OTHER, noise=5, seed=2)
    assert judge(world, tick, grasp_at, after, before)[0] == "SUCCESS"


def test_an_object_that_stayed_is_not_held_and_the_failure_has_the_figures(world, tick, grasp_at):
    status, outcome, code, leaf = judge(world, tick, grasp_at, BEFORE)
    assert (status, outcome, code) == ("FAILURE", "failure", "not_held")
    assert leaf.failure.data["vacated"] == 0.0
    assert world.data["fraction"] == 0.0


@pytest.mark.parametrize("shift", [0.01, 0.03, 0.06, 0.12, 0.2])
@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, -1), (0.7, -0.7)])
def test_an_object_that_was_pushed_is_not_held(world, tick, grasp_at, shift, direction):
    dx, dy = shift * direction[0], shift * direction[1]
    assert judge(world, tick, grasp_at, frame(thing(0.5 + dx, 0.1 + dy), OTHER))[2] == "not_held"


def test_an_object_that_fell_over_is_not_held(world, tick, grasp_at):
    lying = (0.56, 0.05, 0.075, 0.03, 0.06, (205, 60, 45))
    status, _, code, leaf = judge(world, tick, grasp_at, frame(lying, OTHER))
    assert (status, code) == ("FAILURE", "not_held")
    assert leaf.failure.data["appeared"] > 0.25


def test_an_object_of_the_tables_colour_is_told_by_its_height(world, tick, grasp_at):
    before = frame(thing(colour=WOOD), OTHER)
    assert judge(world, tick, grasp_at, frame(OTHER), before)[0] == "SUCCESS"
    assert judge(world, tick, grasp_at, before, before)[2] == "not_held"


def test_another_object_that_vanished_does_not_count(world, tick, grasp_at):
    assert judge(world, tick, grasp_at, frame(thing()))[2] == "not_held"


def test_without_a_grasp_everything_above_the_table_counts(world, tick):
    def fraction(after):
        world.leaf("perception/image_difference", before=BEFORE, after=after).tick_once()
        return world.data["fraction"]

    assert fraction(frame()) > 0.9
    assert 0.3 < fraction(frame(OTHER)) < 0.7


def test_a_place_where_nothing_stood_is_no_evidence(world, tick, grasp_at):
    assert judge(world, tick, grasp_at, frame(OTHER), frame(OTHER))[2] == "no_data"


def test_frames_of_a_camera_that_moved_are_no_evidence(world, tick, grasp_at):
    moved = CameraInfo(320, 240, INFO.matrix, INFO.pose.moved([0.01, 0, 0]))
    status, _, code, leaf = judge(world, tick, grasp_at, frame(OTHER, info=moved))
    assert code == "no_data"
    assert "stood still" in leaf.failure.message


def test_thresholds_are_parameters(world, tick, grasp_at):
    pushed = frame(thing(0.5, 0.3), OTHER)
    assert judge(world, tick, grasp_at, pushed)[2] == "not_held"
    assert judge(world, tick, grasp_at, pushed, max_appeared=5.0)[0] == "SUCCESS"
    assert judge(world, tick, grasp_at, BEFORE, min_vacated=0.0)[0] == "SUCCESS"


# --- capture ---


def test_capture_hands_out_the_frame_and_its_points(world, tick):
    world.context.cameras["overhead"] = SimpleNamespace(capture=lambda: Operation.finished(BEFORE))
    assert tick(world.leaf(sensor_manifest("overhead"))) == ("SUCCESS", "success", None)
    assert world.data["frame"] is BEFORE
    assert world.data["points"].points.shape == (320 * 240, 3)
    world.data.clear()
    world.leaf(sensor_manifest("overhead"), unbound=["points"]).tick_once()
    assert set(world.data) == {"frame", "hidden"}


def test_a_camera_without_a_picture_is_the_failure_no_data(world, tick):
    error = SensorError("dark")
    world.context.cameras["overhead"] = SimpleNamespace(capture=lambda: Operation.failed(error))
    assert tick(world.leaf(sensor_manifest("overhead"))) == ("FAILURE", "failure", "no_data")


def test_an_unknown_sensor_is_found_before_the_run(world):
    with pytest.raises(UnknownNameError, match="camera 'wrist'"):
        world.leaf(sensor_manifest("wrist"))
