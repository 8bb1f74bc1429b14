"""Liquids: nothing is lost, a tilted vessel keeps what geometry lets it, and a pipette draws and releases by rule."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of
from grip_sim.articulated.model import ArticulatedConfig
from grip_sim.liquids import Liquids, VesselConfig
from grip_sim.specs import ObjectSpec, WorldSpec

CUP = VesselConfig(radius=0.03, depth=0.08, bottom=0.003, volume=100)


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.9, 0.9273, 1.1, 1.4, 1.55])
@pytest.mark.parametrize("shape", [(0.03, 0.08), (0.01, 0.15), (0.06, 0.02)])
def test_a_tilted_cylinder_keeps_what_lies_below_its_lip(angle, shape):
    radius, depth = shape
    points = np.random.default_rng(0).uniform((-radius, -radius, 0), (radius, radius, depth), (400_000, 3))
    inside = points[np.hypot(points[:, 0], points[:, 1]) <= radius]
    below = (
        np.sin(angle) * -inside[:, 0] + np.cos(angle) * inside[:, 2] <= np.sin(angle) * -radius + np.cos(angle) * depth
    )
    expected = below.mean() * np.pi * radius**2 * depth * 1e6
    cup = VesselConfig(radius=radius, depth=depth)
    assert cup.capacity(np.cos(angle)) == pytest.approx(expected, abs=0.005 * np.pi * radius**2 * depth * 1e6)


def test_what_lies_or_stands_on_its_head_keeps_nothing():
    assert CUP.capacity(0.0) == CUP.capacity(-1.0) == 0.0


def bench(**at):
    """Return liquids of cups at places, and their poses, which may be changed."""
    poses = {name: Pose(place) for name, place in at.items()}
    liquids = Liquids(poses.__getitem__, lambda name: float(poses[name].rotation()[2, 2]))
    for name in at:
        liquids.add(name, CUP)
    return liquids, poses


def test_only_what_is_under_the_surface_of_a_vessel_is_drawn():
    liquids, _ = bench(cup=(0.5, 0.0, 0.0))
    level = 0.003 + CUP.level(100)
    assert liquids.draw(np.array([0.5, 0.0, level + 1e-4]), 5) == 0
    assert liquids.draw(np.array([0.5, 0.031, 0.01]), 5) == 0
    assert liquids.draw(np.array([0.5, 0.0, 0.002]), 5) == 0
    assert liquids.draw(np.array([0.5, 0.0, level - 1e-4]), 5) == 5
    assert liquids.draw(np.array([0.5, 0.0, level - 1e-4]), 5) == 0, "the surface has sunk"
    assert liquids.volumes == {"cup": 95}


def test_the_surface_of_a_tilted_vessel_stays_level():
    liquids, poses = bench(cup=(0.0, 0.0, 0.0))
    poses["cup"] = Pose((0.0, 0.0, 0.0), quaternion_of(0.4, 0.0, 0.0))
    middle = poses["cup"].apply([(0.0, 0.0, 0.003 + CUP.level(100))])[0]
    low, high = (poses["cup"].apply([(0.0, y, 0.03)])[0] for y in (-0.029, 0.029))
    assert low[2] < middle[2] < high[2]
    assert (liquids.draw(low, 1), liquids.draw(high, 1)) == (1, 0)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["draw", "release", "tilt"]),
            st.sampled_from(["one", "two", ""]),
            st.floats(0, 200),
            st.floats(0, 3.1),
        ),
        max_size=30,
    )
)
def test_whatever_is_done_the_sum_of_all_volumes_stays(steps):
    liquids, poses = bench(one=(0.0, 0.0, 0.0), two=(0.5, 0.0, 0.2))
    held = 0.0
    for what, where, volume, angle in steps:
        tip = poses[where].apply([(0.0, 0.0, 0.004)])[0] if where else np.array([0.2, 0.2, 0.2])
        if what == "draw":
            held += liquids.draw(tip, volume)
        elif what == "release":
            released = min(held, volume)
            held -= released
            liquids.release(tip, released)
        elif where:
            poses[where] = Pose(poses[where].position, quaternion_of(angle, 0.0, 0.0))
        liquids.settle()
        assert held + sum(liquids.volumes.values()) + liquids.spilled == pytest.approx(200)
        for name, inside in liquids.volumes.items():
            assert 0 <= inside <= CUP.capacity(float(poses[name].rotation()[2, 2])) + 1e-9


def test_a_volume_is_not_negative_and_a_radius_is_positive():
    for wrong in ({"radius": 0}, {"depth": -1}, {"volume": -1}):
        with pytest.raises(ValidationError):
            VesselConfig.model_validate({"radius": 0.03, "depth": 0.08} | wrong)


def pipette_world(**said):
    """Return a world with a cup of 100 ml and a pipette whose tip is in it; it is too heavy for forces to move it."""
    pytest.importorskip("sapien")
    from grip_sim.world import World

    pipette = ArticulatedConfig(pipette=said | {"mass": 100.0}, at=(0.5, 0.0, 0.011))
    cup = ObjectSpec("cup", "cylinder", 0.034, 0.01, (0.5, 0.0, 0.005), vessel=CUP)
    return World(WorldSpec(robot="panda", objects=(cup,), cameras=(), articulated={"p": pipette}))


def press(world, force, seconds, lift=None):
    """Press the plunger down [N] while the body is held where it was put, or at another height of its tip."""
    body = world.articulated["p"].body
    root, plunger = body.links
    at = 0.011 if lift is None else lift
    for _ in range(round(seconds / world.spec.dt)):
        plunger.add_force_at_point(np.array([0.0, 0.0, -force]), plunger.entity_pose.p)
        body.set_root_pose(type(root.entity_pose)([0.5, 0.0, at]))
        body.set_root_linear_velocity(np.zeros(3))
        body.set_root_angular_velocity(np.zeros(3))
        world.step()
    return world.measures()


@pytest.mark.sim
@pytest.mark.parametrize("force", [2.4, 3.2])
def test_a_plunger_is_pressed_by_the_law_of_its_spring_and_comes_back(force):
    world = pipette_world(force=4.0)
    weight = 0.006 * 9.81
    assert press(world, force - weight, 0.4)["p_pressed"] == pytest.approx((force - 1.6) / 2.4, abs=0.04)
    assert press(world, 0.0, 0.4)["p_pressed"] == pytest.approx(0, abs=1e-3)
    assert press(world, 20.0, 0.4)["p_pressed"] == pytest.approx(1, abs=1e-3)


@pytest.mark.sim
def test_volumes_move_from_a_vessel_into_a_pipette_and_out_and_what_misses_is_spilled():
    world = pipette_world(volume=5)
    assert world.spec.measures == ("p_pressed", "p_holds", "cup_volume", "spilled")
    press(world, 20.0, 0.3)
    drawn = press(world, 0.0, 0.3)
    assert drawn["p_holds"] == pytest.approx(5, abs=0.02)
    assert drawn["cup_volume"] == pytest.approx(95, abs=0.02)
    kept = world.kept()
    missed = press(world, 20.0, 0.3, lift=0.3)
    assert missed["p_holds"] == pytest.approx(0, abs=0.02)
    assert missed["spilled"] == pytest.approx(5, abs=0.02)
    world.put_back(kept)
    assert press(world, 0.0, 0.1) == pytest.approx(drawn, abs=0.02)
    back = press(world, 20.0, 0.3)
    assert back["cup_volume"] == pytest.approx(100, abs=0.02)
    assert back["spilled"] == 0


@pytest.mark.sim
def test_air_that_is_drawn_after_a_liquid_leaves_before_it():
    world = pipette_world(volume=5)
    press(world, 20.0, 0.3)
    half = press(world, 2.8, 0.3)
    held = half["p_holds"]
    assert 1 < held < 4
    assert press(world, 0.0, 0.3, lift=0.3)["p_holds"] == held, "the rest of the way drew air"
    assert press(world, 2.2, 0.3, lift=0.3)["spilled"] == 0
    assert press(world, 20.0, 0.3, lift=0.3)["spilled"] == pytest.approx(held, abs=0.01)


@pytest.mark.sim
def test_a_vessel_that_is_taken_away_takes_its_volume_along():
    world = pipette_world()
    world.remove("cup")
    assert set(world.measures()) == {"p_pressed", "p_holds"}
    world.step()
