"""Executors and hands over controllers that run in a process of their own."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from patience import PATIENCE, until
from ros_bench import ended, stands

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import CanceledError, ExecutionAbortedError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Executor, HandPort
from grip_bt.base.values import JointState, Trajectory

pytestmark = [pytest.mark.ros, pytest.mark.slow]
NAMES = ("joint_a", "joint_b")


@pytest.fixture(scope="session")
def messages(interface_cache):
    """Return the prefixes of the message packages, built and active here."""
    from grip_bt.ros.interfaces.build import ensure_package

    return [*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]


@pytest.fixture
def robot(start_server, messages):
    """Return a function that starts the robot and returns its process."""
    return partial(start_server, "controller_server.py", overlays=messages)


@pytest.fixture
def states(bus, robot):
    from patient_bus import joints_of

    robot()
    made = joints_of(bus, (*NAMES, "finger"))
    # A last message of the robot before, which was killed, may come after the first of this one.
    until(lambda: np.abs(ended(made.fresh(NAMES)).position).max() < 1e-6)
    return made


@pytest.fixture(params=["trajectory", "topic", "stream"])
def executor(request, bus, states):
    from grip_bt.ros.controllers import StreamedExecutor, TopicExecutor, TrajectoryExecutor

    if request.param == "topic":
        return TopicExecutor(bus, "/arm/joint_trajectory", NAMES, states)
    if request.param == "trajectory":
        return TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    return StreamedExecutor(bus, "/stream/commands", NAMES, states)


def to(goal, duration=0.6, start=(0.0, 0.0), names=NAMES) -> Trajectory:
    part = np.linspace(0, 1, 21)[:, None]
    return Trajectory(names, part[:, 0] * duration, np.array(start) + part * (np.array(goal) - np.array(start)))


def test_a_motion_ends_with_what_is_measured_then(executor):
    assert isinstance(executor, Executor)
    operation = executor.execute(to((0.5, -0.3)))
    assert not operation.done()
    measured = ended(operation)
    assert measured.names == NAMES
    assert measured.position == pytest.approx([0.5, -0.3], abs=1e-3)
    assert measured.time > 0


def test_a_streamed_motion_ends_only_when_the_joints_have_caught_up(bus, robot):
    from patient_bus import joints_of

    from grip_bt.ros.controllers import StreamedExecutor

    robot("slow")
    made = joints_of(bus, NAMES)
    arm = StreamedExecutor(bus, "/stream/commands", NAMES, made)
    # Five times as fast as the joints are: they are still far off when the last set-point is sent.
    assert ended(arm.execute(to((0.5, -0.3), 0.2))).position == pytest.approx([0.5, -0.3], abs=1e-3)


def test_joints_of_a_trajectory_may_come_in_another_order(executor):
    assert ended(executor.execute(to((-0.3, 0.5), names=("joint_b", "joint_a")))).position == pytest.approx([0.5, -0.3])


def test_a_motion_that_begins_elsewhere_is_refused_before_anything_moves(executor):
    with pytest.raises(ExecutionAbortedError, match="starts 0.400 from the measured position of joint joint_a"):
        ended(executor.execute(to((1.0, 0.0), start=(0.4, 0.0))))
    with pytest.raises(ValueError, match="this executor"):
        executor.execute(to((1.0,), start=(0.0,), names=("joint_x",)))
    assert executor.state().position == pytest.approx([0, 0])


@pytest.mark.parametrize("how", ["cancel", "stop"])
def test_a_stopped_motion_ends_as_cancelled_and_the_joints_hold(executor, how):
    operation = executor.execute(to((1.0, 1.0), 60.0))
    until(lambda: executor.state().position[0] > 0.01, "the joints don't move")
    operation.cancel() if how == "cancel" else executor.stop()
    with pytest.raises(CanceledError):
        ended(operation)
    assert stands(executor._states, NAMES)[0] < 0.9


def test_what_the_controller_gives_up_is_an_aborted_motion_with_its_words(bus, states):
    from grip_bt.ros.controllers import TrajectoryExecutor

    arm = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    with pytest.raises(ExecutionAbortedError, match=r"path_tolerance_violated \(joint_a is blocked\)") as caught:
        ended(arm.execute(to((4.0, 0.0))))
    assert caught.value.data["controller_code"] == -4
    other = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", ("joint_a", "finger"), states, wait=PATIENCE)
    start = other.state().position
    with pytest.raises(ExecutionAbortedError) as caught:
        ended(other.execute(to((0.1, 0.08), start=start, names=("joint_a", "finger"))))
    assert caught.value.data["cause"] == "rejected"


def test_a_cancelled_motion_that_a_newer_goal_has_overtaken_ends_as_cancelled(messages):
    from control_msgs.action import FollowJointTrajectory

    from grip_bt.ros.client.goal import GoalEnd
    from grip_bt.ros.controllers.trajectory import as_motion

    given_up = FollowJointTrajectory.Result(error_code=FollowJointTrajectory.Result.INVALID_GOAL)
    for cancelled, error in ((True, CanceledError), (False, ExecutionAbortedError)):
        sent = Operation(on_cancel=lambda: None)
        motion = as_motion(sent, "/arm")
        if cancelled:
            motion.cancel()
        sent.succeed(GoalEnd("aborted", given_up))
        with pytest.raises(error):
            motion.result()


def test_what_isnt_followed_by_a_topic_is_measured_to_stop_short(bus, states):
    from grip_bt.ros.controllers import TopicExecutor

    arm = TopicExecutor(bus, "/arm/joint_trajectory", NAMES, states)
    with pytest.raises(ExecutionAbortedError, match=r"joint_a stands \d\.\d+ short of the end .* the controller's log"):
        ended(arm.execute(to((4.0, 0.0))))
    other = TopicExecutor(bus, "/arm/joint_trajectory", ("joint_a", "finger"), states)
    start = other.state().position
    with pytest.raises(ExecutionAbortedError, match="short of the end") as caught:
        ended(other.execute(to(start + 0.2, start=start, names=("joint_a", "finger"))))
    assert caught.value.data["stopped_short"] == pytest.approx(0.2, abs=1e-3)


def test_a_controller_that_is_not_there_is_an_aborted_motion(bus, states):
    from grip_bt.ros.controllers import StreamedExecutor, TopicExecutor, TrajectoryExecutor

    arm = TrajectoryExecutor(bus, "/nobody/follow_joint_trajectory", NAMES, states, wait=0.3)
    with pytest.raises(ExecutionAbortedError) as caught:
        ended(arm.execute(to((0.1, 0.1))))
    assert caught.value.data["cause"] == "server_lost"
    for kind, topic in ((StreamedExecutor, "/nobody/commands"), (TopicExecutor, "/nobody/joint_trajectory")):
        with pytest.raises(ExecutionAbortedError, match=topic) as caught:
            ended(kind(bus, topic, NAMES, states).execute(to((0.1, 0.1))))
        assert caught.value.data["cause"] == "timed_out"


@pytest.mark.parametrize("way", ["trajectory", "topic"])
def test_a_robot_that_dies_in_the_middle_of_a_motion_ends_it(bus, robot, way):
    from patient_bus import joints_of

    from grip_bt.ros.controllers import TopicExecutor, TrajectoryExecutor

    process = robot()
    states = joints_of(bus, NAMES, stale=3.0)
    kind, name = {
        "trajectory": (TrajectoryExecutor, "/arm/follow_joint_trajectory"),
        "topic": (TopicExecutor, "/arm/joint_trajectory"),
    }[way]
    operation = kind(bus, name, NAMES, states).execute(to((1.0, 1.0), 300.0))

    def moves() -> bool:
        with suppress(SensorError):  # of a busy machine; by topic, that is the end already
            return states.state(NAMES).position[0] > 0
        return operation.done()

    until(moves, "the joints don't move")
    process.kill()
    with pytest.raises(ExecutionAbortedError) as caught:
        ended(operation)
    assert caught.value.data["cause"] == {"trajectory": "server_lost", "topic": "no_data"}[way]
    with pytest.raises(SensorError, match="nothing about joint_a, joint_b"):
        until(lambda: not states.state(NAMES))


def test_joints_that_nobody_publishes_are_named(bus, robot):
    from grip_bt.ros.controllers import JointStates

    robot("none")
    states = JointStates(bus)
    with pytest.raises(SensorError, match="/joint_states: nothing about joint_a, joint_b within 1 s"):
        states.wait_for(NAMES, 0.3)
    with pytest.raises(SensorError):
        ended(states.fresh(NAMES))


class Reader:
    """Stands for the subscription: messages come when the test says so."""

    def listen(self, callback):
        self.callback = callback
        return Operation.finished(None)

    def publishers(self):
        return "1 publisher"


@pytest.fixture
def heard(monkeypatch):
    """Return joint states, and a function that has a message heard: position, stamp [s], time of our clock [s]."""
    from sensor_msgs.msg import JointState as Message

    from grip_bt.ros.client.topic import Received
    from grip_bt.ros.controllers import JointStates, joint_states

    clock, reader = SimpleNamespace(now=1000.0, date=1.8e9), Reader()
    clocks = SimpleNamespace(monotonic=lambda: clock.now, time=lambda: clock.date)
    monkeypatch.setattr(joint_states, "time", clocks)
    states = JointStates(SimpleNamespace(reader=lambda *_: reader))

    def hear(position, stamp, now):
        clock.now = now
        message = Message(name=["joint_a"], position=[position])
        message.header.stamp.sec, message.header.stamp.nanosec = int(stamp), round(stamp % 1 * 1e9)
        reader.callback(Received(message, now))

    return states, hear, clock


def test_what_was_measured_before_and_is_only_heard_now_is_not_the_end_of_a_motion(heard):
    states, hear, clock = heard
    hear(0.0, 50.0, 1000.002)  # whatever the publisher's clock: this one took 2 ms
    clock.now = 1001.0
    fresh = states.fresh(["joint_a"])
    hear(0.0, 50.5, 1001.1)  # measured half a second before, and waited
    assert not fresh.done()
    hear(0.7, 51.05, 1001.11)
    assert fresh.result().position == pytest.approx([0.7])


def test_where_every_message_waited_the_clock_that_both_share_tells_what_came_before(heard):
    states, hear, clock = heard
    hear(0.0, 5000.0, 1000.6)  # all that is known of it waited 0.6 s
    clock.now, clock.date = 1001.0, 5001.0
    fresh = states.fresh(["joint_a"])
    hear(0.1, 5000.5, 1001.1)
    assert not fresh.done()
    hear(0.7, 5001.01, 1001.6)
    assert fresh.result().position == pytest.approx([0.7])


def test_a_clock_that_goes_otherwise_only_takes_longer(heard):
    states, hear, clock = heard
    hear(0.0, 50.0, 1000.0)
    clock.now = 1004.0
    fresh = states.fresh(["joint_a"])
    hear(0.3, 50.4, 1004.1)  # simulated time at a tenth of the wall's
    assert not fresh.done()
    assert ended(fresh).position == pytest.approx([0.3])


def test_with_a_clock_of_ours_a_late_measurement_is_waited_for_as_long_as_joints_are_known(heard):
    states, hear, clock = heard
    states._stale = 600.0
    hear(0.0, 1.8e9, 1000.0)
    clock.now, clock.date = 1001.0, 1.8e9 + 1
    fresh = states.fresh(["joint_a"])
    hear(0.1, 1.8e9 + 0.5, 1002.5)  # measured before, and waited
    assert not fresh.done()
    hear(0.7, 1.8e9 + 1.5, 1003.5)
    assert fresh.result().position == pytest.approx([0.7])


def test_without_stamps_what_is_heard_counts(heard):
    states, hear, clock = heard
    clock.now = 1001.0
    fresh = states.fresh(["joint_a"])
    hear(0.2, 0.0, 1001.1)
    assert fresh.result().position == pytest.approx([0.2])


def test_a_gripper_closes_on_what_is_there_and_opens(bus, states):
    from grip_bt.ros.controllers import GripperHand

    hand = GripperHand(bus, "/gripper/gripper_cmd", "finger", states, wait=PATIENCE)
    assert isinstance(hand, HandPort)
    closed = ended(hand.move(JointState.from_mapping({"finger": 0.0}), 1.0, torque_limit=20.0))
    assert closed.position == pytest.approx([0.02])
    assert hand.contacts() == {"finger": 20.0}
    opened = ended(hand.move(JointState.from_mapping({"finger": 0.06}), 1.0))
    assert opened.position == pytest.approx([0.06])
    assert hand.contacts() == {}
    given_up = ended(hand.move(JointState.from_mapping({"finger": 0.0}), 1.0))  # aborts where it stalls
    assert given_up.position == pytest.approx([0.02])
    assert hand.contacts() == {"finger": 1.0}


class Fingers:
    """Stands for a hand's executor, for what is measured of it, and for a gripper that calls any grasp reached."""

    joint_names = ("finger",)

    def __init__(self):
        self.at, self.stops = 0.04, 0.0

    def state(self, names=joint_names):
        return JointState(("finger",), [self.at], [0.0])

    def fresh(self, names):
        return Operation.finished(self.state())

    def execute(self, trajectory):
        self.at = max(float(trajectory.positions[-1][0]), self.stops)
        return Operation.finished(self.state())

    def stop(self):
        return Operation.finished(self.state())

    def send(self, goal, *_):
        from grip_bt.ros.client.goal import GoalEnd

        self.at = max(goal.command.position, self.stops)
        return Operation.finished(GoalEnd("succeeded", self.result(reached_goal=True, effort=5.0)))


@pytest.mark.parametrize("kind", ["gripper", "trajectory"])
def test_sliding_fingers_hold_what_stops_them_whatever_is_said_of_the_goal(messages, kind):
    from control_msgs.action import GripperCommand

    from grip_bt.ros.controllers import ControlledHand, GripperHand

    fingers = Fingers()
    fingers.result = GripperCommand.Result
    bus = SimpleNamespace(action=lambda *_: fingers)
    hand = (
        GripperHand(bus, "/grip", "finger", fingers)
        if kind == "gripper"
        else ControlledHand(fingers, sliding=("finger",))
    )
    for stops, holds in ((0.015, True), (0.0, False)):
        fingers.stops = stops
        ended(hand.move(JointState.from_mapping({"finger": 0.0}), 1.0))
        assert bool(hand.contacts()) is holds
        ended(hand.move(JointState.from_mapping({"finger": 0.04}), 1.0))
        assert hand.contacts() == {}


def test_fingers_that_stop_short_of_their_posture_touch_something(bus, states):
    from grip_bt.ros.controllers import ControlledHand, TrajectoryExecutor

    hand = ControlledHand(TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE))
    assert isinstance(hand, HandPort)
    ended(hand.move(JointState.from_mapping({"joint_a": 0.3, "joint_b": 0.2}), 0.4))
    assert hand.contacts() == {}
    blocked = ended(hand.move(JointState.from_mapping({"joint_a": 4.0, "joint_b": 0.2}), 0.6))
    assert blocked.position[0] < 3
    assert list(hand.contacts()) == ["joint_a"]


def test_controllers_are_switched_all_or_none_and_only_when_they_are_not_active(bus, states):
    from grip_bt.ros.controllers import ControllerManager
    from grip_bt.ros.controllers.trajectory import SwitchError

    manager = ControllerManager(bus, wait=PATIENCE)
    manager.ensure_active(["arm_controller"], instead_of=["stream_controller"])
    assert manager.states() == {
        "arm_controller": "active",
        "stream_controller": "inactive",
        "broken_controller": "inactive",
    }
    with pytest.raises(UnknownNameError, match="did you mean 'arm_controller'"):
        manager.ensure_active(["arm_controler"])
    with pytest.raises(SwitchError, match="activate broken_controller, deactivate none: no hardware"):
        manager.ensure_active(["broken_controller"])
