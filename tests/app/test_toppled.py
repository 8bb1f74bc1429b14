"""The demonstration's task with an object that has fallen over before it begins."""

import numpy as np
import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.values import Pose
from grip_bt.cli.demo import demo_task

pytestmark = [pytest.mark.ros, pytest.mark.sim, pytest.mark.slow]


def lying(position, axis):
    """Return the pose of an object that lies with its own z along a horizontal direction."""
    along, up = np.array([np.cos(axis), np.sin(axis), 0.0]), np.array([0.0, 0.0, 1.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([np.cross(up, along), up, along], axis=1)
    matrix[:3, 3] = [*position[:2], 0.036]
    return Pose.from_matrix(matrix)


def test_a_toppled_object_is_taken_from_above_and_placed_like_the_others(tmp_path):
    options = RunOptions(seed=1, journal=tmp_path / "j.sqlite")
    with open_session(demo_task(), options) as session:
        referee = session.resources.referee
        *others, (name, truth) = list(referee.truth().items())[:3]
        for k, (other, _) in enumerate(others):  # out of the way: this is about one object
            referee.move_object(other, Pose((0.9, 0.3 + 0.15 * k, 0.09)))
        referee.move_object(name, lying(truth.pose.position, 1.3))
        result = session.runner.run()
        assert referee.truth()[name].status == "placed"
    assert (result.status, result.outcome) == ("success", "cleared")
