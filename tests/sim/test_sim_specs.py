"""World specs: what a seed draws, and how a spec travels."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_sim.specs import (
    CLEARANCE,
    HEIGHT,
    PICK_X,
    PICK_Y,
    RADIUS,
    BoxSpec,
    CameraSpec,
    CrateSpec,
    ObjectSpec,
    TableSpec,
    WorldSpec,
    table_world,
)

SEEDS = st.integers(0, 2**32 - 1)
LENGTHS = st.floats(0.001, 2.0)
POINTS = st.tuples(*[st.floats(-3, 3)] * 3)
COLOURS = st.tuples(*[st.integers(0, 255)] * 3)
RANGES = st.tuples(st.floats(-2, 0), st.floats(0.1, 2))
OBJECTS = st.builds(
    ObjectSpec,
    name=st.text(min_size=1),
    shape=st.sampled_from(["cylinder", "box"]),
    radius=LENGTHS,
    height=LENGTHS,
    position=POINTS,
    yaw=st.floats(-4, 4),
    colour=COLOURS,
)
SPECS = st.builds(
    WorldSpec,
    robot=st.sampled_from(["panda_allegro", "ur5_allegro"]),
    seed=SEEDS,
    objects=st.lists(OBJECTS, max_size=3).map(tuple),
    table=st.builds(TableSpec, x=RANGES, y=RANGES, thickness=LENGTHS, colour=COLOURS),
    crate=st.builds(CrateSpec, centre=st.tuples(LENGTHS, LENGTHS), inner=st.tuples(LENGTHS, LENGTHS)),
    cameras=st.lists(st.builds(CameraSpec, name=st.text(), position=POINTS), max_size=2).map(tuple),
    dt=st.floats(1e-4, 1e-2),
)


@given(SPECS)
@settings(deadline=None)
def test_a_spec_survives_the_way_through_json(spec):
    assert WorldSpec.from_json(json.loads(json.dumps(spec.to_json()))) == spec


@given(SEEDS)
@settings(deadline=None)
def test_a_seed_always_draws_the_same_world(seed):
    assert table_world(seed) == table_world(seed)


def test_different_seeds_draw_different_worlds():
    assert len({table_world(seed).objects for seed in range(50)}) == 50


@given(SEEDS)
@settings(deadline=None)
def test_objects_stand_in_the_pick_region_and_keep_their_distance(seed):
    spec = table_world(seed)
    assert len({thing.name for thing in spec.objects}) == 3
    for thing in spec.objects:
        x, y, z = thing.position
        assert PICK_X[0] <= x <= PICK_X[1]
        assert PICK_Y[0] <= y <= PICK_Y[1]
        assert z == pytest.approx(thing.height / 2)
        assert RADIUS[0] <= thing.radius <= RADIUS[1]
        assert HEIGHT[0] <= thing.height <= HEIGHT[1]
    for one, two in itertools.combinations(spec.objects, 2):
        assert np.hypot(one.position[0] - two.position[0], one.position[1] - two.position[1]) >= CLEARANCE


def test_too_many_objects_are_refused_with_what_would_fit():
    with pytest.raises(ValueError, match="50 objects don't fit at 0.15 m apart; take fewer"):
        table_world(0, objects=50)


def test_the_walls_of_the_crate_enclose_its_inside_and_stand_on_the_table():
    crate = CrateSpec()
    x, y = crate.centre
    left, right, far, near = crate.boxes()
    assert left.low[1] - right.high[1] == pytest.approx(crate.inner[1])
    assert far.low[0] - near.high[0] == pytest.approx(crate.inner[0])
    assert all(box.low[2] == pytest.approx(0) and box.high[2] == pytest.approx(0.06) for box in crate.boxes())
    assert crate.holds((x + 0.12, y - 0.14, 0.05))
    assert not crate.holds((x + 0.14, y, 0.05))
    assert not crate.holds((x, y + 0.16, 0.05))


def test_the_top_of_the_table_is_at_height_zero():
    (top,) = TableSpec().boxes()
    assert top.high[2] == pytest.approx(0)


def test_the_corners_of_a_box_are_half_its_size_from_its_centre():
    box = BoxSpec("b", (0.2, 0.4, 0.6), (1.0, 2.0, 3.0))
    assert box.low == pytest.approx((0.9, 1.8, 2.7))
    assert box.high == pytest.approx((1.1, 2.2, 3.3))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"mass": -1}, r"mass\n.*greater than 0.*input_value=-1"),
        ({"mass": float("nan")}, r"mass\n.*(greater than 0|finite)"),
        ({"shape": "mug"}, r"shape\n.*'cylinder' or 'box'.*'mug'"),
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
    with pytest.raises(ValueError, match="the first number is the smaller one"):
        TableSpec(x=(1.0, 0.3))
    with pytest.raises(ValueError, match=r"dt\n.*greater than 0"):
        WorldSpec(dt=0)
    with pytest.raises(ValueError, match=r"jerks.panda_joint1\n.*greater than 0"):
        WorldSpec(jerks={"panda_joint1": -1.0})
    with pytest.raises(ValueError, match=r"field_of_view\n.*less than 3.14"):
        CameraSpec(field_of_view=4.0)
