"""The one place that imports sapien, without its warning about Vulkan: nothing here renders with it."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import numpy as np

with warnings.catch_warnings():
    warnings.filterwarnings("ignore", message="Failed to find system libvulkan")
    import sapien
    from sapien import physx
    from sapien.wrapper.articulation_builder import ArticulationBuilder, LinkBuilder

from grip_sim.objects.body import ObjectModel
from grip_sim.specs import GRAVITY, ObjectSpec


def make_scene(dt: float) -> sapien.Scene:
    """Return an empty scene that has physics on the CPU only and repeats itself bit by bit.

    `sapien.Scene()` would make a render system, which fails where no Vulkan device is; and the configuration is read
    when the scene is made, so it is set first.
    """
    config = physx.PhysxSceneConfig()
    config.enable_enhanced_determinism = True
    config.gravity = [0.0, 0.0, -GRAVITY]
    physx.set_scene_config(config)
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    scene.set_timestep(dt)
    return scene


def ignore_each_other(shapes: Iterable[physx.PhysxCollisionShape], bit: int) -> None:
    """Have shapes that touch by construction, such as neighbouring links, pass through one another.

    PhysX drops the contact of two shapes when the low 16 bits of word 3 agree and a bit of word 2 is common; a shape
    may be in several such sets.

    Args:
        bit: names the set, 0-31.
    """
    for shape in shapes:
        words = list(shape.get_collision_groups())
        words[2] |= 1 << bit
        words[3] = (words[3] & ~0xFFFF) | 1
        shape.set_collision_groups(words)


SOLID, HAND, SLIPPERY = (1, 1), (4, 5), (2, 1)
"""Words 0 and 1 of collision groups: two shapes touch where word 0 of one and word 1 of the other have a bit in common.
So what is slippery touches everything but hands, and hands touch themselves."""
FIXED = physx.PhysxMaterial(0.0, 0.0, 0.0)
"""Of hands and of everything that never moves; see `movable`."""


def movable(friction: float) -> physx.PhysxMaterial:
    """Return the material of an object whose coefficient against hands and fixtures is `friction`.

    SAPIEN takes the mean of two materials' coefficients and offers no other rule: of `FIXED`, which has none, and of
    twice the object's. Between two objects, the coefficients are therefore added.
    """
    return physx.PhysxMaterial(2 * friction, 2 * friction, 0.0)


def add_model(scene: sapien.Scene, spec: ObjectSpec, model: ObjectModel) -> physx.PhysxRigidDynamicComponent:
    """Put an object of convex parts into a scene, with its mass and inertia [kg, kg m^2], and return its body."""
    body, material = physx.PhysxRigidDynamicComponent(), movable(spec.friction)
    for points in model.parts:
        body.attach(physx.PhysxCollisionShapeConvexMesh(np.float32(points), np.full(3, spec.scale), material))
    moments, axes = np.linalg.eigh(model.inertia)
    frame = np.eye(4)
    frame[:3, :3] = axes * np.linalg.det(axes)  # axes of inertia have no direction: a right-handed set is taken
    frame[:3, 3] = model.centre * spec.scale
    body.set_mass(spec.mass)
    body.set_inertia(moments * spec.mass / model.mass * spec.scale**2)
    body.set_cmass_local_pose(sapien.Pose(frame))
    entity = sapien.Entity()
    entity.set_name(spec.name)
    entity.add_component(body)
    entity.set_pose(sapien.Pose(spec.pose.position, spec.pose.quaternion))
    scene.add_entity(entity)
    return body


__all__ = ["ArticulationBuilder", "LinkBuilder", "physx", "sapien"]
