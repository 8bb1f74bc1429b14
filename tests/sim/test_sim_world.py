"""The physics of a world: repeatable, at rest when nothing happens, with forces that add up."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from patience import PATIENCE

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import Pose
from grip_sim.specs import GRAVITY, BoxSpec, ObjectSpec, WorldSpec
from grip_sim.worlds import load_world

pytestmark = pytest.mark.sim
SCRIPT = """
import json, sys
from grip_sim.specs import WorldSpec
from grip_sim.world import World

world = World(WorldSpec.from_json(json.loads(sys.argv[1])))
robot = world.robot
rows = robot.rows(robot.description.group("arm"))
for step in range(120):
    robot.drive(rows, robot.targets(rows) + float(sys.argv[2]))
    world.step()
print(world.fingerprint())
"""


@pytest.fixture(scope="module")
def make_world():
    from grip_sim.world import World

    return World


@pytest.fixture
def settled(make_world):
    world = make_world(load_world("table", 3))
    advance(world, 0.5)
    return world


def advance(world, seconds):
    for _ in range(round(seconds / world.spec.dt)):
        world.step()


def wave(world, by):
    rows = world.robot.rows(world.robot.description.group("arm"))
    for _ in range(120):
        world.robot.drive(rows, world.robot.targets(rows) + by)
        world.step()


def fingerprint_elsewhere(spec, by):
    command = [sys.executable, "-c", SCRIPT, json.dumps(spec.to_json()), str(by)]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=4 * PATIENCE).stdout.strip()


def test_the_same_spec_and_commands_give_the_same_states_bit_by_bit(make_world):
    one, two, other = (make_world(load_world("table", 5)) for _ in range(3))
    wave(one, 0.001)
    wave(two, 0.001)
    wave(other, 0.0011)
    assert one.fingerprint() == two.fingerprint()
    assert one.fingerprint() != other.fingerprint()


def test_the_same_spec_and_commands_give_the_same_states_in_another_process(make_world):
    spec = load_world("table", 5)
    world = make_world(spec)
    wave(world, 0.001)
    assert fingerprint_elsewhere(spec, 0.001) == world.fingerprint()


def test_objects_and_robot_at_rest_stay_where_they_are(settled):
    before = {thing.name: settled.object_pose(thing.name).matrix() for thing in settled.spec.objects}
    joints = settled.robot.positions()
    advance(settled, 2.0)
    for name, matrix in before.items():
        assert settled.object_pose(name).matrix() == pytest.approx(matrix, abs=1e-4)
        assert settled.object_speeds(name) == pytest.approx((0, 0), abs=1e-3)
    assert settled.robot.positions() == pytest.approx(joints, abs=1e-3)


def test_time_is_the_number_of_steps(make_world):
    world = make_world(WorldSpec())
    assert world.time == 0
    advance(world, 1.0)
    assert world.time == pytest.approx(1.0)


def test_the_table_bears_the_weight_of_each_object(settled):
    contacts = {c[:2]: c for c in settled.contacts()}
    for thing in settled.spec.objects:
        contact, weight = contacts[thing.name, "table"], thing.mass * GRAVITY
        assert contact.push == pytest.approx((0, 0, weight), abs=0.02 * weight)
        assert contacts["table", thing.name].push == pytest.approx((0, 0, -weight), abs=0.02 * weight)
        assert contact.force == pytest.approx(weight, rel=0.02)


def test_a_hand_that_touches_nothing_has_no_contacts(settled):
    assert settled.hand_contacts("hand") == {}


def test_contacts_of_fingers_with_one_another_are_none_of_the_hand(settled):
    hand = settled.robot.rows(settled.robot.description.group("hand"))
    closed = settled.robot.description.named_state("hand", "closed")
    settled.robot.drive(hand, closed.ordered(settled.robot.description.group("hand")))
    advance(settled, 1.0)
    links = settled.robot.hand_links
    assert any(c.body in links and c.other in links for c in settled.contacts())
    assert settled.hand_contacts("hand") == {}


def slid(make_world, friction, slope, seconds=1.0):
    """Return how far a block has slid down an incline of `slope` [rad] since it settled on it, in m."""
    plane = BoxSpec("plane", (2.0, 1.0, 0.1), (0.0, 2.0, 0.5), pitch=slope)
    up = plane.pose.apply([[-0.5, 0.0, 0.05 + 0.02]])[0]
    block = ObjectSpec("block", "box", 0.05, 0.04, tuple(up), tilt=(0.0, slope), friction=friction)
    world = make_world(WorldSpec(boxes=(plane,), objects=(block,), cameras=()))
    advance(world, 0.2)
    start = world.object_pose("block").position
    advance(world, seconds)
    return float(np.linalg.norm(world.object_pose("block").position - start))


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6, 1.0])
def test_a_block_slips_on_an_incline_whose_slope_is_the_angle_of_friction(make_world, friction):
    angle, degree = np.arctan(friction), np.radians(1)
    assert slid(make_world, friction, angle - degree) < 0.002
    assert slid(make_world, friction, angle + degree) > 0.02


def test_an_object_without_friction_slides_as_fast_as_its_weight_pulls_it(make_world):
    slope, seconds = np.radians(20), 0.4
    rest, moved = 0.2, slid(make_world, 0.0, slope, seconds)
    pull = GRAVITY * np.sin(slope)
    assert moved == pytest.approx(pull * ((rest + seconds) ** 2 - rest**2) / 2, rel=0.02)


def test_an_object_that_was_moved_is_there_at_rest_and_touches_nothing_yet(settled):
    name = settled.spec.objects[0].name
    settled.move_object(name, Pose([0.5, 0.1, 0.5]))
    assert settled.object_pose(name).position == pytest.approx([0.5, 0.1, 0.5])
    assert settled.object_speeds(name) == (0, 0)
    assert not [c for c in settled.contacts() if name in c[:2]]
    advance(settled, 0.1)
    fallen = 0.5 - settled.object_pose(name).position[2]
    assert fallen == pytest.approx(0.5 * GRAVITY * 0.1**2, rel=0.1)


def test_unknown_names_list_those_that_exist(settled):
    with pytest.raises(UnknownNameError, match="overhead"):
        settled.cameras.look("overhaed")
    with pytest.raises(UnknownNameError, match=settled.spec.objects[0].name):
        settled.object_pose("nothing")
    with pytest.raises(UnknownNameError, match="hand_palm_link"):
        settled.link_pose("palm")


@pytest.mark.parametrize("names", [("thing", "thing"), ("table",), ("hand_palm_link",)])
def test_two_things_of_one_name_are_refused(make_world, names):
    things = [ObjectSpec(name, "box", 0.03, 0.1, (0.5, 0.2 * i, 0.05)) for i, name in enumerate(names)]
    with pytest.raises(ValueError, match=f"more than one is '{names[0]}'"):
        make_world(WorldSpec(objects=tuple(things)))


def test_a_limited_drive_gives_no_more_than_its_limit(settled):
    robot = settled.robot
    rows = robot.rows(robot.description.group("hand"))
    robot.limit_torque(rows, 0.1)
    robot.drive(rows, robot.targets(rows) + 1.0)
    efforts = []
    for _ in range(60):
        settled.step()
        efforts.append(np.abs(robot.measure(rows).effort).max())
    assert max(efforts) == pytest.approx(0.1)


def test_what_was_kept_is_put_back_in_another_world_of_the_same_kind(make_world):
    one, other = make_world(load_world("table", 3)), make_world(load_world("table", 3))
    rows = one.robot.rows(one.robot.description.group("arm"))
    one.robot.drive(rows, one.robot.positions()[rows] + 0.2)
    for _ in range(60):
        one.step()
    kept = one.kept()
    assert other.fingerprint() != one.fingerprint()
    other.put_back(kept)
    assert other.fingerprint() == one.fingerprint()
    for world in (one, other):
        for _ in range(60):
            world.step()
    assert other.robot.positions() == pytest.approx(one.robot.positions(), abs=1e-3), "and goes on as it would have"
    for name in one._objects:
        assert other.object_pose(name).position == pytest.approx(one.object_pose(name).position, abs=1e-3)


def test_the_state_of_another_world_is_refused_and_changes_nothing(make_world):
    one = make_world(load_world("table", 3))
    before, kept = one.fingerprint(), one.kept()
    with pytest.raises(ValueError, match="another world: this one has"):
        one.put_back({**kept, "poses": kept["poses"][:1]})
    with pytest.raises(ValueError, match="another robot: this one has"):
        one.put_back({**kept, "positions": kept["positions"][:3]})
    assert one.fingerprint() == before
