"""Values of runs as a page shows them."""

from __future__ import annotations

from base64 import b64decode
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from played import TASK, TestClient

from grip_bt.base.value_codec import snapshot
from grip_bt.base.values import CameraInfo, DepthImage, Grasp, Image, JointState, PointCloud, Pose, RgbdFrame
from grip_bt.runtime import Journal
from grip_bt.runtime.journal import DetailedEvent
from grip_gui.runs.drawings import LARGEST, drawn_cloud, drawn_depth, png
from grip_gui.runs.values import PLACES, POINTS, ROWS, cloud_view, value_view


def pixels_of(data: bytes) -> NDArray[np.uint8]:
    """Read back a PNG."""
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    return cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def test_a_picture_comes_back_pixel_by_pixel() -> None:
    picture = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert (pixels_of(png(picture)) == picture).all()


def test_the_highest_point_of_a_cloud_is_seen_from_above_with_y_upwards() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5], [0, 1, 0.1]], dtype=np.float32)
    colors = np.array([[9, 0, 0], [0, 9, 0], [0, 0, 9], [9, 9, 9]], dtype=np.uint8)
    picture = drawn_cloud(points, colors)
    assert picture[-1, 0].tolist() == [9, 0, 0]
    assert picture[-1, -1].tolist() == [0, 9, 0]
    assert picture[0, 0].tolist() == [0, 0, 9]


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.zeros((1, 3)), np.full((3, 3), np.nan)])
def test_clouds_without_extent_are_drawn(points: NDArray[Any]) -> None:
    assert drawn_cloud(points.astype(np.float32)).shape[2] == 3


def test_near_is_lighter_than_far_and_nothing_seen_is_neither() -> None:
    picture = drawn_depth(np.array([[0.5, 2.0, 0.0]], dtype=np.float32))
    assert picture[0, 0, 0] > picture[0, 1, 0]
    assert picture[0, 2].tolist() == [16, 16, 48]


def test_a_large_image_is_made_smaller() -> None:
    view = value_view("Image", Image(np.zeros((480, 640, 3), dtype=np.uint8)))
    assert pixels_of(b64decode(view.picture.partition(",")[2])).shape == (240, 320, 3)
    assert LARGEST == 320
    assert view.caption == "640 x 480 pixels"


def test_a_pose_is_said_in_metres_and_degrees() -> None:
    view = value_view("Pose", Pose([0.1, 0.2, 0.3], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], "table"))
    assert view.text == "at (0.1, 0.2, 0.3) m in table, roll 0.0, pitch 0.0, yaw 90.0 deg"
    assert ["frame", "table"] in view.rows


def test_long_lists_show_their_beginning() -> None:
    rows = value_view("list[int]", list(range(1000))).rows
    assert rows[0] == ["0", "0"]
    assert len(rows) == ROWS + 1
    assert rows[-1][0] == "..."


@pytest.fixture
def written(project: Path) -> str:
    """A run that has written a cloud, a depth image and a number."""
    info = CameraInfo(2, 1, np.diag([100.0, 100.0, 1.0]))
    with Journal(project / ".grip" / "runs.sqlite") as journal:
        log = journal.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        for value in (PointCloud(np.ones((40, 3))), DepthImage(np.array([[1.0, 2.0]]), info), 3):
            facts = {"variable": "count", "type": type(value).__name__}
            log.note(0.0, "first", DetailedEvent("write", data=facts, written=(snapshot(value),)))
        log.append(1.0, "first", "exit", "success", None, {})
        log.end("success", None)
    return str(log.id)


def test_what_a_write_wrote_is_shown_with_its_drawing(page: TestClient, written: str) -> None:
    cloud, depth, number = (page.get(f"/api/runs/{written}/values/{seq}").json() for seq in (1, 2, 3))
    assert cloud["picture"].startswith("data:image/png;base64,")
    assert "40 points" in cloud["caption"]
    assert depth["caption"] == "2 x 1 pixels, 1 to 2 m"
    assert (number["text"], number["picture"]) == ("3", "")


@pytest.mark.parametrize("seq", ["4", "99", "0", "-1", "x", str(2**70)])
def test_what_is_no_write_is_refused(page: TestClient, written: str, seq: str) -> None:
    assert page.get(f"/api/runs/{written}/values/{seq}").status_code in {404, 422}
    assert page.get("/api/runs/nobody/values/1").status_code == 404


def test_joint_states_are_told_joint_by_joint() -> None:
    assert value_view("JointState", JointState(("a", "b"), [0.25, -1.5])).text == "a 0.25, b -1.5"


def test_poses_and_grasps_say_where_they_are_drawn() -> None:
    at = Pose((0.5, 0.1, 0.2), frame="table")
    (place,) = value_view("Pose", at).places
    assert (place.frame, place.at) == ("table", [0.5, 0.1, 0.2, 1, 0, 0, 0])
    grasps = [Grasp(at, at.moved((0, 0, 0.1)), at.moved((0, 0, 0.2)))] * 20
    places = value_view("list[Grasp]", grasps).places
    assert [place.name for place in places[:3]] == ["0 grasp", "0 before", "0 after"]
    assert len(places) == PLACES
    assert value_view("int", 3).places == []


def points_of(text: str) -> NDArray[np.float32]:
    return np.frombuffer(b64decode(text), "<f4").reshape(-1, 3)


def test_a_cloud_is_drawn_in_space_with_its_colours_and_without_what_was_not_seen() -> None:
    points = np.array([[0, 0, 1], [np.nan, 0, 0], [2, 3, 4]], dtype=np.float32)
    colors = np.array([[1, 2, 3], [4, 5, 6], [7, 8, 9]], dtype=np.uint8)
    view = cloud_view(PointCloud(points, colors, "camera"))
    assert points_of(view.points).tolist() == [[0, 0, 1], [2, 3, 4]]
    assert list(b64decode(view.colors)) == [1, 2, 3, 7, 8, 9]
    assert (view.frame, view.of) == ("camera", 3)


def test_of_a_large_cloud_some_points_are_drawn_from_its_beginning_to_its_end() -> None:
    points = np.linspace((0, 0, 0), (1, 1, 1), 3 * POINTS + 1, dtype=np.float32)
    view = cloud_view(PointCloud(points))
    drawn = points_of(view.points)
    assert POINTS / 2 < len(drawn) <= POINTS
    assert drawn[0, 0] == 0
    assert drawn[-1, 0] > 0.99
    assert (view.of, view.colors) == (len(points), "")


def test_what_a_camera_with_depth_saw_is_a_cloud_and_other_values_are_none() -> None:
    info = CameraInfo(2, 1, np.array([[1.0, 0, 1], [0, 1, 0.5], [0, 0, 1]]), Pose((0, 0, 1), frame="rig"))
    frame = RgbdFrame(Image(np.full((1, 2, 3), 7, np.uint8)), DepthImage(np.array([[0, 2]], np.float32), info))
    view = cloud_view(frame)
    assert points_of(view.points).tolist() == [[1, 0, 3]]
    assert view.frame == "rig"
    assert cloud_view(Pose()).points == cloud_view(3).points == ""
