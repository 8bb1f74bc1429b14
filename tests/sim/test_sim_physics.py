"""What physics has to be right about in every world: how deep things sink in, energy, and the time of a fall."""

from __future__ import annotations

import numpy as np
import pytest

from grip_sim.specs import GRAVITY, ObjectSpec, WorldSpec
from grip_sim.worlds import BUILTIN, load_world

pytestmark = pytest.mark.sim


@pytest.fixture(scope="module")
def make_world():
    from grip_sim.world import World

    return World


def bodies(world):
    return [world._object(thing.name) for thing in world.spec.objects]


def energy(body):
    """Return a body's kinetic and potential energy [J]."""
    turn = (body.entity_pose * body.cmass_local_pose).to_transformation_matrix()[:3, :3]
    spin = turn.T @ body.angular_velocity
    height = (body.entity_pose * body.cmass_local_pose).p[2]
    moving = body.mass * np.dot(body.linear_velocity, body.linear_velocity) + np.dot(body.inertia * spin, spin)
    return float(moving / 2 + body.mass * GRAVITY * height)


@pytest.mark.parametrize("name", [name for name in BUILTIN if load_world(name).objects])
@pytest.mark.parametrize("seed", [0, 17])
def test_what_rests_sinks_in_by_less_than_half_a_millimetre(make_world, name, seed):
    world = make_world(load_world(name, seed))
    for _ in range(int(3 / world.spec.dt)):
        world.step()
    objects = {thing.name for thing in world.spec.objects}
    touching = [c for c in world.scene.get_contacts() if objects & {body.entity.name for body in c.bodies}]
    depths = [point.separation for contact in touching for point in contact.points]
    assert depths
    assert min(depths) > -5e-4


@pytest.mark.parametrize("seed", [1, 5])
def test_energy_of_what_falls_and_collides_does_not_grow(make_world, seed):
    world = make_world(load_world("clutter_bin", seed))
    before = sum(energy(body) for body in bodies(world))
    scale = sum(body.mass for body in bodies(world)) * GRAVITY * 0.1  # of falling 10 cm
    for _ in range(int(2 / world.spec.dt)):
        world.step()
        now = sum(energy(body) for body in bodies(world))
        assert now < before + 0.01 * scale
        before = min(before, now)


@pytest.mark.parametrize("dt", [1 / 240, 1 / 480])
@pytest.mark.parametrize("height", [0.1, 0.5, 1.0])
def test_a_ball_falls_as_long_as_it_should(make_world, height, dt):
    ball = ObjectSpec("ball", "sphere", 0.02, 0.04, (0.5, 0.5, height + 0.02))
    world = make_world(WorldSpec(objects=(ball,), cameras=(), dt=dt))
    while not any("ball" in contact[:2] for contact in world.contacts()):
        world.step()
        assert world.time < 1
    assert world.time == pytest.approx(
        np.sqrt(2 * height / GRAVITY), abs=2 * world.spec.dt + 0.02 / np.sqrt(2 * GRAVITY * height)
    )


@pytest.mark.parametrize(("length", "angle"), [(0.2, 0.1), (0.5, 0.6)])
def test_a_pendulum_keeps_its_period_and_gains_no_energy(make_world, length, angle):
    """Against 2 pi sqrt((I + m l^2) / (m g l)), with the first two terms of what a wide swing takes longer."""
    from grip_sim.physics import make_scene, sapien

    dt, mass, inertia = 1 / 240, 0.3, 1e-4
    scene = make_scene(dt)
    builder = scene.create_articulation_builder()
    hinge = builder.create_link_builder()
    rod = builder.create_link_builder(hinge)
    rod.set_joint_properties("revolute", [[-np.pi, np.pi]], sapien.Pose(), sapien.Pose(), 0.0, 0.0)
    rod.set_mass_and_inertia(mass, sapien.Pose([0, 0, -length]), [inertia] * 3)
    body = builder.build(fix_root_link=True)
    body.set_sleep_threshold(0.0)
    body.active_joints[0].set_friction(0.0)
    for link in body.links:
        link.set_linear_damping(0.0)
        link.set_angular_damping(0.0)
    body.set_qpos(np.float32([angle]))
    moment, passed, highest, before = inertia + mass * length**2, list[float](), 0.0, angle
    for step in range(int(8 / dt)):
        scene.step()
        now, speed = float(body.get_qpos()[0]), float(body.get_qvel()[0])
        highest = max(highest, moment * speed**2 / 2 + mass * GRAVITY * length * (1 - np.cos(now)))
        if now * before < 0:
            passed.append((step + before / (before - now)) * dt)
        before = now
    wide = 1 + angle**2 / 16 + 11 * angle**4 / 3072
    period = 2 * np.pi * np.sqrt(moment / (mass * GRAVITY * length)) * wide
    assert 2 * np.diff(passed).mean() == pytest.approx(period, rel=0.005)
    assert highest < 1.03 * mass * GRAVITY * length * (1 - np.cos(angle))
