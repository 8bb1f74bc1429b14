"""Where joints hold when a streamed motion is stopped: on their way, however late what is measured of them comes."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import numpy as np
import pytest
from patience import PATIENCE

from grip_bt.base.failures import CanceledError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory

pytestmark = pytest.mark.ros
NAMES = ("joint_a", "joint_b")
WAY = Trajectory(("joint_b", "joint_a"), np.array([0.0, 2.0]), np.array([[0.0, 0.0], [-1.0, 2.0]]))


class Joints:
    """Stands for the topic of set-points, and for what is measured: what `measured` makes of these."""

    def __init__(self, measured):
        self.measured, self.sent, self.enough = measured, [], threading.Event()

    def publish(self, message, subscribers):
        self.sent.append(np.array(message.data))
        if len(self.sent) == 20:
            self.enough.set()
        return Operation.finished(None)

    def watch(self, names, enough, within):
        return Operation.finished(True)

    def state(self, names):
        found = JointState(NAMES, self.measured(self.sent) if self.sent else np.zeros(2))
        return JointState(tuple(names), found.ordered(names))


def silent(sent):
    raise SensorError("nothing is heard")


def stopped(measured):
    from grip_bt.ros.controllers import StreamedExecutor

    joints = Joints(measured)
    arm = StreamedExecutor(SimpleNamespace(writer=lambda *_: joints, watchdog=None), "/commands", NAMES, joints)
    operation = arm.execute(WAY)
    assert joints.enough.wait(PATIENCE)
    arm.stop()
    assert operation.wait(PATIENCE)
    with pytest.raises(CanceledError):
        operation.result()
    return np.array(joints.sent)


@pytest.mark.parametrize(
    "measured",
    [lambda sent: sent[-1], lambda sent: sent[max(0, len(sent) - 12)], silent],
    ids=["at once", "late", "nothing"],
)
def test_joints_on_their_way_come_to_rest_further_on_it_and_never_go_back(measured):
    sent = stopped(measured)
    assert sent[:, 0] == pytest.approx(-2 * sent[:, 1], abs=1e-9), "on their way"
    assert (np.diff(sent[:, 0]) >= 0).all()
    even = (sent[19] - sent[0]) / 19
    braking = np.flatnonzero(np.diff(sent[:, 0]) < 0.1 * even[0])
    assert len(braking), "the last set-points are closer and closer"
    assert sent[-1, 0] - sent[19, 0] > 0.2, "by a ramp, not at once"


def test_joints_that_something_holds_back_are_told_to_stay_where_they_are():
    blocked = np.array([0.0, -0.2])
    sent = stopped(lambda sent: blocked)
    assert sent[-1] == pytest.approx(blocked)
