"""The served controller of `grip sim` obeys what it acknowledges: said by a plain rclpy client, in its own process."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from plain_client import PlainClient, plain_client, swing
from simulated_robot import ARM, ARM_ACTION, simulated_robot

pytestmark = [pytest.mark.ros, pytest.mark.sim, pytest.mark.slow, pytest.mark.timeout(1200)]
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
LONG = 20.0


@pytest.fixture(scope="module")
def client(own_domain, tmp_path_factory) -> Iterator[PlainClient]:
    from grip_bt.ros.interfaces.build import ensure_package

    overlays = ensure_package("control_msgs")
    with (
        simulated_robot(tmp_path_factory.mktemp("sim"), own_domain),
        plain_client(ARM_ACTION, "trajectory", ARM, own_domain, overlays) as made,
    ):
        yield made


def away(client: PlainClient) -> list:
    """A long swing of the first joint, to the other side of where it is."""
    goal = client.now.copy()
    goal[0] += -1.2 if goal[0] > 0 else 1.2
    return swing(client.now, goal, LONG)


@pytest.mark.parametrize("how", ["cancel", "all", "early"])
def test_a_cancelled_goal_stops_and_says_so(client, how):
    points = away(client)
    said = client.move(points, 2.0, how)
    assert (said["return_code"], said["canceling"]) == (0, 1)
    assert (said["status"], said["error_code"]) == (CANCELED, 0)
    assert np.abs(client.now - points[-1][1]).max() > 0.3
    at_end = [row for row in said["samples"] if row[0] > said["ended"]]
    assert np.ptp([row[2] for row in at_end], axis=0).max() < 2e-3, "the joints still moved when it was over"


def test_a_cancel_of_a_goal_that_another_one_has_replaced_leaves_that_alone(client):
    points = swing(client.now, client.now + 0.2 * np.eye(7)[0], 3.0)
    said = client.move(points, 0.5, "replace")
    assert said["status"] in (ABORTED, CANCELED)
    assert said["second"] == SUCCEEDED


def test_whoever_follows_a_goal_hears_where_the_joints_are(client):
    said = client.move(swing(client.now, client.now + 0.2 * np.eye(7)[0], 2.0))
    assert said["status"] == SUCCEEDED
    assert said["feedback"] > 5
