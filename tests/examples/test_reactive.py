"""The reactive example: its image difference, its drawn poses, and that only what the component saw taken is placed."""

import importlib.util
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import scripted
from grip_bt.base.values import Grasp, Pose
from grip_bt.nodes.node import Observer
from grip_bt.runtime import RunContext
from grip_bt.task.catalog import load_implementation

EXAMPLES = Path(__file__).parents[2] / "examples"
TASK = EXAMPLES / "tasks" / "reactive.yaml"
ATTEMPT = "next_object/attempt"
HEIGHT, WIDTH, AWAY = 240, 320, 1.3
SIZE = 14
"""Pixels along a thing's side."""


def loaded(file):
    spec = importlib.util.spec_from_file_location(f"{file.stem}_under_test", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


difference = loaded(EXAMPLES / "components/image_difference/difference.py")
places = st.tuples(st.integers(10, HEIGHT - 30), st.integers(10, WIDTH - 30))


def frame(things, seed, shadow=None):
    """Colour and depth of a table with things on it, each at (row, column), as a noisy camera sees them."""
    random = np.random.default_rng(seed)
    colour, depth = np.full((HEIGHT, WIDTH, 3), 150, int), np.full((HEIGHT, WIDTH), AWAY)
    if shadow is not None:
        colour[shadow[0] : shadow[0] + SIZE, shadow[1] : shadow[1] + SIZE] -= 90
    for row, column in things:
        colour[row : row + SIZE, column : column + SIZE] = (200, 60, 40)
        depth[row : row + SIZE, column : column + SIZE] = AWAY - 0.08
    colour += random.normal(0, 6, colour.shape).astype(int)
    depth += random.normal(0, 0.002, depth.shape)
    depth[random.random(depth.shape) < 0.01] = 0.0
    return colour.clip(0, 255).astype(np.uint8), depth.astype(np.float32)


def apart(*spots):
    return all(
        abs(a[0] - b[0]) > SIZE + 3 or abs(a[1] - b[1]) > SIZE + 3 for k, a in enumerate(spots) for b in spots[:k]
    )


@settings(max_examples=40, deadline=None)
@given(places, places, places, st.integers(0, 2**32 - 1))
def test_what_was_taken_moved_or_left_alone_is_told_apart(place, other, third, seed):
    if not apart(place, other, third):
        return
    before = frame([place, other], seed)

    def against(things, **kwargs):
        return difference.compare(*before, *frame(things, seed + 1, **kwargs))

    taken, moved, alone = against([other]), against([other, third]), against([place, other], shadow=third)
    area = SIZE * SIZE
    assert 0.7 * area < taken.vacated < 1.1 * area
    assert taken.appeared == 0
    assert 0.7 * area < moved.vacated < 1.1 * area
    assert 0.7 * area < moved.appeared < 1.1 * area
    assert alone == difference.Difference(0, 0)


@pytest.fixture(scope="module")
def draw():
    manifest = project_catalog(EXAMPLES).get("reactive/draw_pose")
    leaf = load_implementation(manifest)("leaf", "task/leaf", manifest, {"radius": 0.008, "seed": 3}, {})
    leaf.setup(context=RunContext())

    def drawn(grasp, number):
        data = {}
        leaf.readers.update(grasp=lambda: grasp, number=lambda: number)
        leaf.writers["grasp"] = lambda value: data.__setitem__("grasp", value)
        leaf.tick_once()
        return data["grasp"]

    return drawn


@given(st.integers(1, 10_000))
def test_a_drawn_pose_lies_within_the_radius_and_the_whole_grasp_moves(draw, number):
    above, higher = Pose((0.5, 0.1, 0.22), (0, 1, 0, 0)), Pose((0.5, 0.1, 0.3), (0, 1, 0, 0))
    grasp = Grasp(Pose((0.5, 0.1, 0.1), (0, 1, 0, 0)), above, higher, quality=0.7)
    assert draw(grasp, 0) == grasp
    other = draw(grasp, number)
    shift = other.pose.position - grasp.pose.position
    assert 0 < np.linalg.norm(shift) <= 0.008
    assert shift[2] == 0
    for name in ("pre_grasp", "post_grasp"):
        np.testing.assert_allclose(getattr(other, name).position - getattr(grasp, name).position, shift, atol=1e-12)
        assert np.array_equal(getattr(other, name).quaternion, getattr(grasp, name).quaternion)
    assert draw(grasp, number) == other


class Watcher(Observer):
    def __init__(self):
        self.begun, self.said = Counter(), Counter()

    def entered(self, path):
        self.begun[path.removeprefix(f"{ATTEMPT}/")] += 1

    def ended(self, path, outcome, failure):
        if path == f"{ATTEMPT}/check/grasped":
            self.said[outcome] += 1


@pytest.mark.parametrize("form", ["bt", "sm"])
@pytest.mark.parametrize(
    "script",
    [
        "taken",
        "moved,untouched,taken,taken",
        "failure.server_lost,taken,moved,taken,untouched,taken",
        "moved,untouched,failure.server_lost,moved",
    ],
)
def test_placing_is_tried_only_after_the_component_saw_that_the_thing_was_taken(script, form, tmp_path):
    looks = ["failure"] * 8 + ["success"]
    scripts = {"check/grasped": script, "todo/clear": looks, "place/put": "success"}
    mocks = scripted({f"{ATTEMPT}/{node}": played for node, played in scripts.items()})
    options = RunOptions(target=form, robot="fake", mocks=mocks, journal=tmp_path / "runs.sqlite")
    watcher = Watcher()
    with open_session(TASK, options) as session:
        session.runner.observe(watcher)
        result = session.runner.run()
    begun, said = watcher.begun, watcher.said
    assert begun["check/grasped"] == said.total() >= 4
    assert begun["place/put"] == begun["tally"] == said["taken"]
    assert begun["check/let_go"] == said.total() - said["taken"]
    assert result.outcome == ("cleared" if "taken" in script else "gave_up"), result
