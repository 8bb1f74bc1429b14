"""Goals of a served controller: whichever thread is first, the newest goal is the one that is followed."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import numpy as np
import pytest

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState

pytestmark = pytest.mark.ros


class Held:
    """Stands for a thread that begins when the test says so."""

    threads: list[Held] = []

    def __init__(self, target, args, **_):
        self.run = lambda: target(*args)
        Held.threads.append(self)

    def start(self):
        """Wait for the test."""


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_an_older_goal_never_takes_the_place_of_a_newer_one(order, monkeypatch):
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    from grip_bt.ros import served_controllers as module

    monkeypatch.setattr(module, "threading", SimpleNamespace(Thread=Held, Lock=threading.Lock))
    Held.threads.clear()
    followed = []
    served = object.__new__(module.TrajectoryController)
    served._bus = SimpleNamespace(post=lambda work: work(), node=SimpleNamespace(executor=None))
    served._executor = SimpleNamespace(
        state=lambda: JointState(("a",), np.zeros(1), np.zeros(1)),
        execute=lambda path: followed.append(float(path.positions[-1][0])) or Operation.finished(None),
    )
    served._lock, served._goals, served._newest = threading.Lock(), {}, None
    for number, end in enumerate((0.1, 0.2)):
        point = JointTrajectoryPoint(positions=[end])
        point.time_from_start.sec = 1
        asked = SimpleNamespace(trajectory=JointTrajectory(joint_names=["a"], points=[point]))
        goal_id = SimpleNamespace(uuid=bytes([number] * 16))
        served._accepted(
            SimpleNamespace(goal_id=goal_id, request=asked, execute=lambda: None, is_cancel_requested=False)
        )
    older = served._goals[bytes(16)]
    for number in order:
        Held.threads[number].run()
    assert followed == [pytest.approx(0.2)]
    assert isinstance(older.future.result(), CanceledError)


def test_the_single_point_of_a_stream_is_passed_at_the_speed_that_leads_to_it():
    """As joint_trajectory_controller has positions without velocities; a goal rests at its end."""
    from trajectory_msgs.msg import JointTrajectoryPoint

    from grip_bt.ros.served_controllers import continued

    point = JointTrajectoryPoint(positions=[0.3])
    point.time_from_start.nanosec = 100_000_000
    state = JointState(("a",), np.array([0.1]), np.array([0.5]))
    assert continued(["a"], [point], state, True).sampled(np.array([0.0, 0.1]))[1][:, 0] == pytest.approx([2.0, 2.0])
    assert continued(["a"], [point], state, False).velocities[:, 0] == pytest.approx([0.5, 0.0])
