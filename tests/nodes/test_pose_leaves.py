import numpy as np
import pytest

from grip_bt.base.values import Pose


def test_a_pose_is_made_of_numbers_and_wrong_ones_are_found_before_the_run(world, tick):
    leaf = world.leaf("pose/make", position=[1.0, 2.0, 3.0], quaternion=[0.0, 0.0, 0.0, 2.0], frame="crate")
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.data["pose"] == Pose((1, 2, 3), (0, 0, 0, 1), "crate")
    with pytest.raises(ValueError, match="position"):
        world.leaf("pose/make", position=[1.0])
    with pytest.raises(ValueError, match="quaternion"):
        world.leaf("pose/make", position=[1.0, 2.0, 3.0], quaternion=[0.0, 0.0, 0.0, 0.0])


def test_a_pose_is_moved_along_the_frames_axes_or_its_own(world, tick):
    quarter = Pose((1, 0, 0), (np.sqrt(0.5), 0, 0, np.sqrt(0.5)))
    tick(world.leaf("pose/offset", pose=quarter, position=[0.1, 0.0, 0.0]))
    assert world.data["moved"].position == pytest.approx([1.1, 0, 0])
    tick(world.leaf("pose/offset", pose=quarter, position=[0.1, 0.0, 0.0], own_axes=True))
    assert world.data["moved"].position == pytest.approx([1, 0.1, 0])
    tick(world.leaf("pose/offset", pose=quarter, quaternion=[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]))
    assert world.data["moved"].rotation() @ [1, 0, 0] == pytest.approx([-1, 0, 0])
