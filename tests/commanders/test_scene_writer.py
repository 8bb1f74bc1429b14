"""What is written as a `.scene` file is read as the same scene."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box, Cylinder, Mesh, Sphere
from grip_bt.commanders.scene_file import parse_scene, scene_text
from grip_bt.commanders.scene_state import SceneObject

LENGTHS = st.floats(0.001, 5.0)
SHAPES = st.one_of(
    st.builds(Box, st.tuples(LENGTHS, LENGTHS, LENGTHS)),
    st.builds(Sphere, LENGTHS),
    st.builds(Cylinder, LENGTHS, LENGTHS),
)
POSES = st.builds(
    lambda position, q: Pose(position, np.array(q) / np.linalg.norm(q)),
    st.tuples(*[st.floats(-3, 3)] * 3),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1),
)


@settings(deadline=None)
@given(st.lists(st.tuples(SHAPES, POSES), max_size=5))
def test_what_is_written_is_read(things):
    objects = [SceneObject(f"thing {i}", shape, pose) for i, (shape, pose) in enumerate(things)]
    read = parse_scene(scene_text("room", objects)) if objects else ()
    assert [item.name for item in read] == [item.name for item in objects]
    for before, after in zip(objects, read, strict=True):
        assert type(after.shape) is type(before.shape)
        for field in ("size", "radius", "height"):
            if hasattr(before.shape, field):
                assert getattr(after.shape, field) == pytest.approx(getattr(before.shape, field), rel=1e-6)
        assert after.pose.matrix() == pytest.approx(before.pose.matrix(), abs=1e-6)


def test_a_mesh_is_written_too():
    points = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], dtype=float)
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
    (read,) = parse_scene(scene_text("room", [SceneObject("tip", Mesh(points, triangles), Pose())]))
    assert isinstance(read.shape, Mesh)
    assert read.shape.points == pytest.approx(points)
    assert (read.shape.triangles == triangles).all()


def test_what_a_scene_file_cannot_say_is_refused():
    with pytest.raises(ValueError, match="is held by right_hand"):
        scene_text("room", [SceneObject("mug", Sphere(0.1), Pose(), hand="right_hand")])
