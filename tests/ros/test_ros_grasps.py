"""Other people's conventions of one grasp come to one value: messages, frames, units and axes."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.base.errors import ContractError
from grip_bt.base.values import CameraInfo, DepthImage, Image, Pose, RgbdFrame
from grip_bt.cli.component import rendered
from grip_bt.ros.client.types import ConversionError
from grip_bt.ros.component import Adapter
from grip_bt.ros.convert_values import pose_to_message, pose_to_stamped
from grip_bt.ros.frames import FrameTree
from grip_bt.task.catalog.component_file import ComponentFile

pytestmark = pytest.mark.ros
COMPONENTS = Path(__file__).parents[2] / "examples" / "benchmark" / "components"


class Said:
    """A message of somebody's own: fields of whatever types."""

    def __init__(self, **fields):
        self.__dict__.update(fields)

    @classmethod
    def get_fields_and_field_types(cls):
        return dict.fromkeys(FIELDS, "double")


Said.__module__ = "own.msg"  # where messages tell what they are called
FIELDS = "header pose place out across width score row column turn away grasps list poses".split()


def adapter(grasp, frames=None, **port):
    port = {"type": "list[Grasp]", "field": "grasps", "grasp": grasp, **port}
    file = {"name": "c", "interface": "p/srv/S", "server": "/s", "outcomes": 1, "ports": {"grasps": port}}
    return Adapter(ComponentFile.model_validate(file), frames)


def read(grasp, item, request=None, frames=None, around=None, **port):
    said = Said(grasps=[item]) if around is None else Said(list=Said(header=around, grasps=[item]))
    path = "grasps" if around is None else "list.grasps"
    return adapter(grasp, frames, **{"field": path, **port}).unpack(said, "grasps", path, request or {})[0]


def camera(pose):
    return CameraInfo(320, 240, np.array([[536.0, 0, 160], [0, 530.0, 120], [0, 0, 1]]), pose)


def turned(tips, approach, closing):
    """The pose whose axes `approach` and `closing` are the z and y of `tips`."""
    rotation, made = tips.rotation(), np.zeros((3, 3))
    for name, column in ((approach, rotation[:, 2]), (closing, rotation[:, 1])):
        made[:, "xyz".index(name[-1])] = -column if name[0] == "-" else column
    third = 3 - "xyz".index(approach[-1]) - "xyz".index(closing[-1])
    made[:, third] = np.cross(made[:, (third + 1) % 3], made[:, (third + 2) % 3])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = made, tips.position
    return Pose.from_matrix(matrix, tips.frame)


def vector(numbers):
    from geometry_msgs.msg import Vector3

    return Vector3(**dict(zip("xyz", map(float, numbers), strict=True)))


def alike(one, other):
    for name in ("pose", "pre_grasp", "post_grasp"):
        a, b = getattr(one, name), getattr(other, name)
        assert a.frame == b.frame == "world"
        np.testing.assert_allclose(a.matrix(), b.matrix(), atol=1e-9)
    assert one.width == pytest.approx(other.width)
    assert one.quality == pytest.approx(other.quality)


numbers = st.floats(-1, 1)
quaternions = st.tuples(numbers, numbers, numbers, numbers).filter(lambda q: math.hypot(*q) > 0.1)
poses = st.builds(Pose, st.tuples(numbers, numbers, numbers), quaternions)
signed = st.sampled_from(["x", "y", "z", "-x", "-y", "-z"])
pairs = st.tuples(signed, signed).filter(lambda pair: pair[0][-1] != pair[1][-1])


@settings(max_examples=60, deadline=None)
@given(poses, poses, pairs, st.floats(0.001, 0.2), numbers)
def test_a_grasp_is_one_value_whatever_poses_vectors_units_and_frames_say_it(tips, eye, pair, width, score):
    own = turned(tips, *pair)
    seen = eye.inverse("optical") @ own
    frames, depth = FrameTree({"optical": eye}), DepthImage(np.ones((240, 320)), camera(eye))
    out, across = ((eye.inverse("optical") @ tips).rotation()[:, k] for k in (2, 1))
    axes = {"approach": pair[0], "closing": pair[1], "quality": "score"}
    more = {"width": width, "score": score}
    first = read({"pose": "pose", "width": "width", **axes}, Said(pose=pose_to_message(own), **more))
    np.testing.assert_allclose(first.pose.matrix(), tips.matrix(), atol=1e-9)
    np.testing.assert_allclose(first.pre_grasp.position, tips.position - 0.12 * tips.rotation()[:, 2], atol=1e-9)
    np.testing.assert_allclose(first.post_grasp.position, tips.position + [0, 0, 0.15], atol=1e-9)
    assert (first.width, first.quality, first.provenance) == (width, score, "c")
    # millimetres in the robot's base frame
    large = Pose(1000 * own.position, own.quaternion)
    thousand = {"width": {"field": "width", "unit": "mm"}, "pose": "pose", **axes}
    alike(first, read(thousand, Said(pose=pose_to_message(large), width=1000 * width, score=score), unit="mm"))
    # in a camera's frame, which the pose's header names, or that of the list around it, or the port
    said = {"pose": "pose", "width": "width", **axes}
    alike(first, read(said, Said(pose=pose_to_stamped(seen), **more), frames=frames))
    plain = Said(pose=pose_to_message(seen), **more)
    alike(first, read(said, plain, frames=frames, around=pose_to_stamped(seen).header))
    alike(first, read(said, plain, frames=frames, frame="optical"))
    # in the frame of the camera that took an input, wherever a header says it is
    wrong = Said(pose=pose_to_stamped(Pose(seen.position, seen.quaternion, "world")), **more)
    for sent in (depth, depth.info, RgbdFrame(Image(np.zeros((240, 320, 3))), depth)):
        alike(first, read({**said, "camera": "view"}, wrong, {"view": sent}))
    # a palm, the way out of it, and the line along which fingers close
    vectors = {"position": "place", "approach": "-out", "closing": "across", "offset": 0.1, "width": "width"}
    palm = Said(place=vector(100 * (seen.position - 0.1 * out)), out=vector(-3 * out), across=vector(across), **more)
    alike(first, read({**vectors, "quality": "score"}, palm, frames=frames, frame="optical", unit="cm"))


@settings(max_examples=60, deadline=None)
@given(poses, st.floats(0, 319), st.floats(0, 239), st.floats(0.2, 2), st.floats(-7, 7), st.floats(1, 90))
def test_a_line_in_an_image_is_the_grasp_that_the_camera_projects_to_it(eye, column, row, away, angle, wide):
    info = camera(eye)
    depth = DepthImage(np.full((240, 320), away, np.float32), info)
    grasp = {"column": "column", "row": "row", "angle": {"field": "-turn", "unit": "deg"}, "depth": "away"}
    grasp |= {"camera": "view", "width": {"field": "width", "unit": "px"}}
    item = Said(column=column, row=row, turn=-np.degrees(angle), away=away, width=wide)
    made = read(grasp, item, {"view": depth})
    ends = [made.pose.position + k * made.width / 2 * made.pose.rotation()[:, 1] for k in (-1, 1)]
    half = wide / 2 * np.array([np.cos(angle), np.sin(angle)])
    middle = np.array([column, row]) + 0.5
    np.testing.assert_allclose(info.project(np.array(ends)), [middle - half, middle + half], atol=1e-6)
    np.testing.assert_allclose(made.pose.rotation()[:, 2], eye.rotation()[:, 2], atol=1e-9)
    looked_up = read({**grasp, "depth": None}, item, {"view": depth})
    np.testing.assert_allclose(looked_up.pose.position, made.pose.position, atol=1e-5)


def test_a_pose_array_needs_no_field_and_a_single_grasp_no_list():
    pose = Pose((0.1, 0.2, 0.3))
    whole = read({"approach": "x", "closing": "y"}, pose_to_message(pose))
    np.testing.assert_allclose(whole.pose.rotation()[:, 2], [1, 0, 0], atol=1e-12)
    one = adapter({}, type="Grasp", field="pose").unpack(Said(pose=pose_to_message(pose)), "grasps", "pose")
    assert one.pose == pose


@pytest.mark.parametrize(
    ("grasp", "item", "said"),
    [
        ({"width": "widht"}, {}, r"grasps\[0\]\.widht|widht: .*no such field; did you mean 'width'"),
        ({"width": "width"}, {"width": math.nan}, r"width: nan is no number"),
        ({"camera": "view"}, {}, "nothing was sent as 'view'"),
        ({}, {"frame": "nowhere"}, "given in 'nowhere', whose place in world isn't known: unknown frame 'nowhere'"),
        ({"position": "place", "approach": "out", "closing": "out"}, {}, "parallel"),
        ({"position": "place", "approach": "across", "closing": "out"}, {}, "across: the vector has no direction"),
    ],
)
def test_what_makes_no_grasp_is_told_with_its_field(grasp, item, said):
    pose = pose_to_stamped(Pose(frame=item.pop("frame", "world")))
    fields = {"pose": pose, "place": vector((1, 2, 3)), "out": vector((0, 0, -1)), "across": vector((0, 0, 0))}
    way = {} if "position" in grasp else {"pose": "pose"}
    with pytest.raises(ConversionError, match=said):
        read({**way, **grasp}, Said(**{**fields, "width": 0.1, **item}), frames=FrameTree({"camera": Pose()}))


@pytest.mark.parametrize(
    ("component", "wrong", "said"),
    [
        (
            "pca_top",
            ("field: width_mm", "field: widht_mm"),
            "TopGrasp has no field 'widht_mm'; did you mean 'width_mm'",
        ),
        ("pca_top", ("quality: score", "quality: pose"), "pose is geometry_msgs/Pose, which isn't a number"),
        ("image_antipodal", ("camera: depth_image", "camera: image"), "'image' isn't an input with a camera"),
        (
            "cloud_antipodal",
            ("closing: binormal", "closing: -binormel"),
            "no field 'binormel'; did you mean 'binormal'",
        ),
    ],
)
def test_a_field_that_the_messages_of_a_component_lack_is_told_before_it_runs(component, wrong, said, tmp_path):
    home = tmp_path / "components" / component
    shutil.copytree(COMPONENTS / component, home, ignore=shutil.ignore_patterns("node", "__pycache__"))
    file = home / "component.yaml"
    rendered(home)
    file.write_text(file.read_text().replace(*wrong))
    with pytest.raises(ContractError, match=said):
        rendered(home)


@pytest.mark.parametrize(
    ("grasp", "said"),
    [
        ({"approach": "w"}, "'w' isn't an axis of a pose: write one of x, y, z, -x, -y, -z"),
        ({"approach": "z", "closing": "-z"}, "two axes at right angles"),
        ({"pose": "pose", "position": "place"}, "`pose` and `position` are two ways to say a grasp"),
        ({"position": "place"}, "`position` needs `approach` and `closing`, fields with a vector each"),
        ({"column": "u", "row": "v", "angle": "t"}, "`column` needs `row`, `angle` and `camera`"),
        ({"width": {"field": "width", "unit": "px"}}, "width: 'px' isn't one of its units: m, cm, mm, in"),
        ({"width": {"field": "width", "unit": "yard"}}, "unit"),
        ({"widht": "width"}, "widht"),
    ],
)
def test_a_description_that_makes_no_sense_is_told_with_what_would(grasp, said):
    with pytest.raises(ValidationError, match=said):
        adapter(grasp)
