"""World files: what a seed draws of them, what they may hold, and what is said where something doesn't fit."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_sim.noise import PRESETS
from grip_sim.worlds import BUILTIN, ArrangementError, load_world, read_world, world_files

SEEDS = st.integers(0, 2**32 - 1)


def written(folder, text, name="mine"):
    """Return the path of a world file of a project."""
    (folder / "worlds").mkdir(exist_ok=True)
    path = folder / "worlds" / f"{name}.yaml"
    path.write_text("grip: 1\n" + text)
    return path


@pytest.mark.parametrize("name", BUILTIN)
@given(seed=SEEDS)
@settings(deadline=None, max_examples=20)
def test_a_seed_always_draws_the_same_world(name, seed):
    assert load_world(name, seed) == load_world(name, seed)


@pytest.mark.parametrize("name", BUILTIN)
def test_every_seed_fits_into_a_built_in_world_and_names_differ(name):
    for seed in range(300):
        spec = load_world(name, seed)
        names = [thing.name for thing in (*spec.objects, *spec.boxes, *spec.meshes)]
        assert len(set(names)) == len(names)
        assert spec.cameras


def test_different_seeds_draw_different_worlds():
    assert len({load_world("table", seed).objects for seed in range(50)}) == 50


@given(SEEDS)
@settings(deadline=None)
def test_what_is_drawn_lies_in_its_region_on_its_floor_and_keeps_its_distance(seed):
    (region,) = (region for region in load_world("table").regions if region.name == "pick")
    spec = load_world("table", seed)
    assert len({thing.name for thing in spec.objects}) == 3
    for thing in spec.objects:
        assert region.holds(thing.position)
        assert thing.position[2] == pytest.approx(thing.height / 2)
        assert 0.028 <= thing.radius <= 0.034
        assert 0.14 <= thing.height <= 0.17
        assert 0.18 <= thing.mass <= 0.22
    for one, two in itertools.combinations(spec.objects, 2):
        assert np.hypot(one.position[0] - two.position[0], one.position[1] - two.position[1]) >= 0.15


CROWDED = """
regions:
  pick: {size: [0.2, 0.2, 0.2], at: [0.5, 0, 0.1]}
objects:
  things: {draw: 50, of: [{shape: sphere, radius: 0.03}], in: pick%s}
"""


def test_an_arrangement_that_does_not_fit_says_what_does(tmp_path):
    with pytest.raises(ArrangementError, match=r"objects/things: 50 objects 0.07 m apart don't fit into the region "):
        load_world(str(written(tmp_path, CROWDED % "")))
    with pytest.raises(ArrangementError, match=r"'pick' \(0.2 x 0.2 m\): 1?[0-9] do"):
        load_world("mine", 0, tmp_path)


def test_what_falls_begins_one_above_the_other(tmp_path):
    spec = load_world(str(written(tmp_path, CROWDED % ", drop: true")))
    heights = [thing.position[2] for thing in spec.objects]
    assert len(heights) == 50
    assert all(high - low >= 0.06 for low, high in itertools.pairwise(heights))


def test_a_thing_stands_at_its_place_and_a_camera_looks_where_it_is_told(tmp_path):
    text = """
objects:
  ball: {shape: sphere, radius: 0.03, at: [0.4, 0.1, 0.2]}
cameras:
  front: {at: [1.5, 0.3, 0.9], look_at: [0.5, 0.0, 0.1]}
  wrist: {at: [0.05, 0, 0], look_at: [0.05, 0, 1], link: panda_link8, noise: realsense, renderer: raster}
dt: 0.002
"""
    spec = load_world(str(written(tmp_path, text)))
    assert spec.dt == 0.002
    (ball,), (camera, wrist) = spec.objects, spec.cameras
    assert (wrist.link, wrist.noise, wrist.renderer) == ("panda_link8", PRESETS["realsense"], "raster")
    assert ball.position == pytest.approx((0.4, 0.1, 0.23))
    x, y, z = camera.info().pose.inverse().apply([[0.5, 0.0, 0.1]])[0]
    assert (x, y) == pytest.approx((0, 0), abs=1e-9)
    assert z > 1
    assert camera.info().pose.rotation()[2, 1] < 0, "the image's y points down"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("objects: {a: {shape: sphere, at: [0, 0, 0]}}", "a sphere needs a `radius`"),
        ("objects: {a: {shape: mug, radius: 1, at: [0, 0, 0]}}", "'mug'"),
        ("objects: {a: {shape: sphere, radius: 0.1}}", r"needs a place: `at: \[x, y, z\]`"),
        ("objects: {a: {shape: sphere, radius: [0.2, 0.1], at: [0, 0, 0]}}", "the first number is the smaller one"),
        ("objects: {a: {shape: sphere, radius: 0.1, at: [0, 0, 0], mass: -1}}", "greater than 0"),
        ("objects: {a: {draw: 2, of: [{shape: sphere, radius: 0.1}], in: there}}", r"no region 'there' \(available: "),
        ("objects: {a: {draw: 2, in: there}}", "drawn objects need `of:"),
        ("fixtures: {a: {at: [0, 0, 0]}}", "open_box"),
        ("fixtures: {a: {box: [1, 1, 0]}}", "greater than 0"),
        ("cameras: {a: {at: [0, 0, 1], look_at: [0, 0, 1]}}", "can't look at where it is"),
        ("objcts: {}", "objects"),
    ],
)
def test_a_wrong_world_is_refused_with_its_place_and_what_is_allowed(tmp_path, text, told):
    path = written(tmp_path, text)
    with pytest.raises(DocumentError, match=told) as caught:
        read_world("mine", tmp_path)
    assert str(path) in str(caught.value)


def test_the_world_of_the_docs_is_one(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "worlds.md").read_text()
    example = text.split("```yaml\n")[1].split("```")[0]
    spec = load_world(str(written(tmp_path, example.removeprefix("grip: 1\n"))))
    assert [thing.name for thing in spec.objects] == ["ball", "mug", "cylinder_0", "cylinder_1"]
    assert all(f"`{name}`" in text for name in BUILTIN)


def test_a_world_of_the_project_hides_a_built_in_one_and_an_unknown_one_is_told_of(tmp_path):
    path = written(tmp_path, "doc: ours", "table")
    assert world_files(tmp_path)["table"] == path
    assert read_world("table", tmp_path)[0].doc == "ours"
    with pytest.raises(UnknownNameError, match="did you mean 'table'"):
        load_world("tabel")
