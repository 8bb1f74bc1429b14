"""Objects that come and go while a world runs are like those that were there: seen, touched, disturbed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import Pose
from grip_sim.faults import Fault
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.world import World
from grip_sim.worlds import object_at

pytestmark = pytest.mark.sim
CAMERA = CameraSpec("above", 64, 48, 0.6, (0.6, 0.0, 1.0), renderer="raster", target=(0.6, 0.0, 0.0))
CAN = ObjectSpec("can", "cylinder", 0.03, 0.1, (0.6, 0.0, 0.051))


def made(*objects: ObjectSpec) -> World:
    return World(WorldSpec(robot="panda", objects=objects, cameras=(CAMERA,)))


def advanced(world: World, steps: int) -> World:
    for _ in range(steps):
        world.step()
    return world


def test_what_is_spawned_moves_and_looks_as_if_it_had_always_been_there():
    there, spawned = made(CAN), made()
    spawned.cameras.look("above")  # the renderer exists already
    spawned.spawn(CAN)
    for world in (there, spawned):
        advanced(world, 60)
    assert np.array_equal(there.object_pose("can").matrix(), spawned.object_pose("can").matrix())
    assert np.array_equal(there.cameras.look("above").depth, spawned.cameras.look("above").depth)
    assert there.kept().keys() == spawned.kept().keys()


def test_what_is_removed_is_neither_seen_nor_touched_nor_disturbed():
    world, empty = made(CAN), made()
    world.inject("bump", Fault(fault="push", of="can", by=(1, 0, 0), at=0.1))
    world.remove("can")
    advanced(world, 60)
    assert np.array_equal(world.cameras.look("above").depth, advanced(empty, 60).cameras.look("above").depth)
    assert not [contact for contact in world.contacts() if "can" in contact[:2]]
    with pytest.raises(UnknownNameError, match="can"):
        world.object_pose("can")
    world.spawn(CAN)
    assert [spec.name for spec in world.spec.objects] == ["can"]


def test_what_is_removed_while_it_is_touched_is_touched_no_longer():
    world = advanced(made(replace(CAN, position=(0.6, 0.0, 0.05))), 60)
    assert [contact for contact in world.contacts() if "can" in contact[:2]]
    world.remove("can")
    assert not [contact for contact in world.contacts() if "can" in contact[:2]]
    world.spawn(CAN)
    assert not [contact for contact in world.contacts() if "can" in contact[:2]]


def test_names_stay_unique():
    world = made(CAN)
    with pytest.raises(ValueError, match="can"):
        world.spawn(CAN)
    assert len(world.spec.objects) == 1


def test_a_camera_may_begin_to_be_late():
    world = advanced(made(CAN), 5)
    world.inject("lag", Fault(fault="late", lag=0.1))
    world.step()
    first = world.cameras.look("above")
    world.move_object("can", Pose([0.7, 0.1, 0.051]))
    assert np.array_equal(advanced(world, 12).cameras.look("above").depth, first.depth)
    assert not np.array_equal(advanced(world, 24).cameras.look("above").depth, first.depth)


def test_an_object_of_the_library_is_put_as_it_is_turned():
    pose = Pose([0.5, 0.1, 0.3], [0.5, 0.5, -0.5, 0.5])
    spec = object_at("my_mug", "mug", pose)
    assert np.allclose(spec.pose.matrix(), pose.matrix(), atol=1e-9)
