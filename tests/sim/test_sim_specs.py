"""World specs: what a seed draws, and how a spec travels."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_sim.specs import TABLE, BoxSpec, CameraSpec, MeshSpec, ObjectSpec, RegionSpec, WorldSpec, open_box

SEEDS = st.integers(0, 2**32 - 1)
LENGTHS = st.floats(0.001, 2.0)
POINTS = st.tuples(*[st.floats(-3, 3)] * 3)
COLOURS = st.tuples(*[st.integers(0, 255)] * 3)
OBJECTS = st.builds(
    ObjectSpec,
    name=st.text(min_size=1),
    shape=st.sampled_from(["cylinder", "box", "sphere"]),
    radius=LENGTHS,
    height=LENGTHS,
    position=POINTS,
    yaw=st.floats(-4, 4),
    colour=COLOURS,
)
SIZES = st.tuples(LENGTHS, LENGTHS, LENGTHS)
YAWS = st.floats(-4, 4)
BOXES = st.builds(BoxSpec, name=st.text(), size=SIZES, centre=POINTS, colour=COLOURS, yaw=YAWS)
REGIONS = st.builds(RegionSpec, name=st.text(), size=SIZES, centre=POINTS, yaw=YAWS, target=st.booleans())
SPECS = st.builds(
    WorldSpec,
    robot=st.sampled_from(["panda_allegro", "ur5_allegro"]),
    seed=SEEDS,
    objects=st.lists(OBJECTS, max_size=3).map(tuple),
    boxes=st.lists(BOXES, max_size=3).map(tuple),
    meshes=st.lists(st.builds(MeshSpec, name=st.text(), file=st.text(), position=POINTS), max_size=2).map(tuple),
    regions=st.lists(REGIONS, max_size=2).map(tuple),
    floor=st.floats(-2, 0),
    cameras=st.lists(st.builds(CameraSpec, name=st.text(), position=POINTS), max_size=2).map(tuple),
    dt=st.floats(1e-4, 1e-2),
)


@given(SPECS)
@settings(deadline=None)
def test_a_spec_survives_the_way_through_json(spec):
    assert WorldSpec.from_json(json.loads(json.dumps(spec.to_json()))) == spec


@given(REGIONS, SIZES)
def test_a_region_holds_what_lies_within_its_edges_however_it_is_turned(region, shares):
    inside = np.array(region.size) / 2 * np.minimum(shares, 0.99)
    outside = np.array([region.size[0] / 2 * 1.01, 0.0, 0.0])
    assert region.holds(region.pose.apply([inside])[0])
    assert not region.holds(region.pose.apply([outside])[0])


def test_the_walls_of_an_open_box_enclose_its_inside_and_stand_on_its_floor():
    x, y, z = at = (0.48, -0.40, 0.1)
    left, right, far, near = open_box("crate", (0.26, 0.30, 0.06), at)
    assert left.centre[1] - left.size[1] / 2 - y == pytest.approx(0.15)
    assert y - right.centre[1] - right.size[1] / 2 == pytest.approx(0.15)
    assert far.centre[0] - far.size[0] / 2 - x == pytest.approx(0.13)
    assert x - near.centre[0] - near.size[0] / 2 == pytest.approx(0.13)
    assert all(box.centre[2] - box.size[2] / 2 == pytest.approx(z) for box in (left, right, far, near))


def test_the_top_of_the_table_is_at_height_zero():
    assert TABLE.centre[2] + TABLE.size[2] / 2 == pytest.approx(0)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"mass": -1}, r"mass\n.*greater than 0.*input_value=-1"),
        ({"mass": float("nan")}, r"mass\n.*(greater than 0|finite)"),
        ({"shape": "mug"}, r"shape\n.*'cylinder', 'box', 'sphere' or 'model'.*'mug'"),
        ({"radius": 0}, r"radius\n.*greater than 0"),
        ({"friction": -0.1}, r"friction\n.*greater than or equal to 0"),
        ({"position": (0.5, 0.0, float("inf"))}, r"position.2\n.*finite"),
        ({"colour": (200, 60, 256)}, r"colour.2\n.*less than or equal to 255"),
    ],
)
def test_an_object_that_no_world_can_hold_is_refused_with_what_is_allowed(wrong, told):
    right = {"name": "cup", "shape": "cylinder", "radius": 0.03, "height": 0.1, "position": (0.5, 0.0, 0.05)}
    with pytest.raises(ValueError, match=rf"ObjectSpec\n{told}"):
        ObjectSpec(**{**right, **wrong})


def test_the_rest_of_a_world_is_checked_too():
    with pytest.raises(ValueError, match=r"dt\n.*greater than 0"):
        WorldSpec(dt=0)
    with pytest.raises(ValueError, match=r"jerks.panda_joint1\n.*greater than 0"):
        WorldSpec(jerks={"panda_joint1": -1.0})
    with pytest.raises(ValueError, match=r"field_of_view\n.*less than 3.14"):
        CameraSpec(field_of_view=4.0)
