"""The one place that imports sapien, without its warning about Vulkan: nothing here renders with it."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

with warnings.catch_warnings():
    warnings.filterwarnings("ignore", message="Failed to find system libvulkan")
    import sapien
    from sapien import physx

from grip_sim.specs import GRAVITY


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
        shapes: the set.
        bit: names the set, 0-31.
    """
    for shape in shapes:
        words = list(shape.get_collision_groups())
        words[2] |= 1 << bit
        words[3] = (words[3] & ~0xFFFF) | 1
        shape.set_collision_groups(words)


FIXED = physx.PhysxMaterial(0.0, 0.0, 0.0)
"""Of hands and of everything that never moves; see `movable`."""


def movable(friction: float) -> physx.PhysxMaterial:
    """Return the material of an object whose coefficient against hands and fixtures is `friction`.

    SAPIEN takes the mean of two materials' coefficients and offers no other rule: of `FIXED`, which has none, and of
    twice the object's. Between two objects, the coefficients are therefore added.
    """
    return physx.PhysxMaterial(2 * friction, 2 * friction, 0.0)


__all__ = ["FIXED", "movable", "ignore_each_other", "make_scene", "physx", "sapien"]
