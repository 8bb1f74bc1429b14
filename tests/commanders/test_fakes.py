"""Scripts and schedules of the fakes; that they keep the ports' promises is tested in tests/contracts."""

import numpy as np
import pytest
from timed import ManualClock, OnClock, TimedArm, TimedExecutor

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    ExecutionAbortedError,
    NoIkError,
    NoPlanError,
    SensorError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.base.ports import Arm, Camera, Component
from grip_bt.base.values import CameraInfo, DepthImage, Image, JointState, Pose, RgbdFrame, Trajectory
from grip_bt.commanders.fake import FakeArm, FakeCamera, FakeComponent, FakeExecutor, FakeHand
from grip_bt.commanders.hand import HandCommander

START = JointState(("a",), [0.0])


def ramp(end=1.0):
    return Trajectory(("a",), [0.0, 2.0], [[0.0], [end]])


def test_things_due_on_a_clock_happen_in_order_within_one_move():
    clock, happened = ManualClock(), []
    schedule = OnClock(clock)
    for delay in (3.0, 1.0, 2.0, 1.0):
        schedule.after(delay, lambda delay=delay: happened.append((delay, clock.now())))
    clock.advance(0.999)
    assert happened == []
    clock.advance(1.5)
    assert [delay for delay, _ in happened] == [1.0, 1.0, 2.0]
    clock.advance(0.501)
    assert [delay for delay, _ in happened] == [1.0, 1.0, 2.0, 3.0]


def test_an_executor_follows_its_script_and_then_does_as_asked():
    clock = ManualClock()
    executor = TimedExecutor(START, OnClock(clock), script=[ExecutionAbortedError("stuck"), None])

    def done(trajectory):
        operation = executor.execute(trajectory)
        for _ in range(20):
            clock.advance(0.1)
        return operation.result().position

    with pytest.raises(ExecutionAbortedError, match="stuck"):
        done(ramp())
    assert executor.state().position == pytest.approx([0.5])
    assert done(Trajectory(("a",), [0.0, 1.0], [[0.5], [0.0]])) == pytest.approx([0.0])
    assert done(ramp()) == pytest.approx([1.0])
    assert len(executor.executed) == 3


def test_a_motion_has_ended_when_it_has_begun():
    executor = FakeExecutor(START)
    assert executor.execute(ramp()).result().position == pytest.approx([1.0])


def test_an_executor_refuses_joints_that_are_not_its_own():
    with pytest.raises(ValueError, match="moves"):
        FakeExecutor(START).execute(Trajectory(("b",), [0.0], [[0.0]]))


def test_a_new_motion_ends_the_one_under_way():
    clock = ManualClock()
    executor = TimedExecutor(START, OnClock(clock))
    first = executor.execute(ramp())
    clock.advance(1.0)
    second = executor.execute(Trajectory(("a",), [0.0, 1.0], [[0.5], [0.7]]))
    assert first.done()
    clock.advance(1.0)
    assert second.result().position == pytest.approx([0.7])
    clock.advance(5.0)
    assert executor.state().position == pytest.approx([0.7])


def test_an_arms_script_names_verbs_and_unknown_ones_are_refused():
    arm = TimedArm(script={"plan": [NoPlanError("wall")], "plan_straight": [None, NoIkError("far")]})
    assert isinstance(arm, Arm)
    with pytest.raises(NoPlanError, match="wall"):
        arm.plan("home").result()
    arm.plan("home").result()
    arm.plan_straight([arm.grasp_pose()]).result()
    with pytest.raises(NoIkError):
        arm.plan_straight([arm.grasp_pose()]).result()
    with pytest.raises(UnknownNameError, match="plan_straight"):
        TimedArm(script={"plan_strait": []})


def test_a_fake_arm_is_where_it_was_sent_whatever_the_turn():
    rng = np.random.default_rng(0)
    arm = FakeArm()
    for _ in range(20):
        pose = Pose(rng.uniform(-1, 1, 3), rng.normal(size=4))
        arm.plan(pose).then(arm.execute).result()
        assert arm.grasp_pose().matrix() == pytest.approx(pose.matrix(), abs=1e-9)


def test_a_hand_keeps_the_torque_limits_that_it_was_given():
    hand = FakeHand(START, thing=JointState(("a",), [0.5]))
    commander = HandCommander("h", hand, {"open": START, "closed": JointState(("a",), [1.0])})
    commander.close(torque_limit=0.3).result()
    assert hand.torque_limits == [0.3]
    assert hand.state().position == pytest.approx([0.5])
    assert hand.contacts() == {"fingertip": 5.0}
    commander.close(force=3.0).result()
    assert hand.contacts() == {"fingertip": 3.0}
    with pytest.raises(ValueError, match="positive"):
        commander.close(torque_limit=0.0)
    with pytest.raises(UnknownNameError, match="joint"):
        commander.open(JointState(("b",), [1.0]))


def test_joints_that_a_posture_does_not_name_stay():
    start = JointState(("a", "b"), [0.1, 0.2])
    commander = HandCommander("h", FakeHand(start), {"open": start})
    measured = commander.open(JointState(("b",), [0.9])).result()
    assert measured.as_mapping() == pytest.approx({"a": 0.1, "b": 0.9})


def test_whispers_of_contact_are_no_contact():
    start, closed = START, JointState(("a",), [1.0])
    hand = FakeHand(start, thing=JointState(("a",), [0.5]), forces={"tip": 0.01})
    operation = HandCommander("h", hand, {"open": start, "closed": closed}).close()
    with pytest.raises(Exception, match="without touching"):
        operation.result()


def test_a_camera_gives_its_frames_in_turn_and_fails_where_told():
    info = CameraInfo(2, 1, np.eye(3))
    frame = RgbdFrame(Image(np.zeros((1, 2, 3))), DepthImage(np.ones((1, 2)), info))
    camera = FakeCamera(info, [frame, SensorError("dark")])
    assert isinstance(camera, Camera)
    assert camera.capture().result() is frame
    with pytest.raises(SensorError, match="dark"):
        camera.capture().result()
    assert camera.capture().result() is frame
    with pytest.raises(SensorError, match="no frames"):
        FakeCamera(info).capture().result()


def test_a_component_replies_in_turn():
    replies = [{"outcome": 0}, lambda request: {"outcome": request["input"]}, ServerTimeOutError("slow")]
    component = FakeComponent(replies)
    assert isinstance(component, Component)
    operations = [component.call({"input": 7}) for _ in range(3)]
    assert [operation.result() for operation in operations[:2]] == [{"outcome": 0}, {"outcome": 7}]
    with pytest.raises(ServerTimeOutError):
        operations[2].result()
    with pytest.raises(ServerLostError):
        FakeComponent().call({}).result()


def own_arm():
    return FakeArm(own=JointState(("j1", "j2"), [0.1, 0.2]))


def test_a_fake_arm_takes_goals_of_its_robots_own_joints_and_the_others_stay():
    arm = own_arm()
    before = arm.grasp_pose()
    reached = arm.execute(arm.plan(JointState(("j2",), [1.2])).result()).result()
    assert reached.as_mapping() == {**arm.state().as_mapping(), "j1": pytest.approx(0.1), "j2": pytest.approx(1.2)}
    assert arm.grasp_pose().position == pytest.approx(before.position)
    arm.execute(arm.plan(Pose((0.4, 0.1, 0.6))).result()).result()
    assert arm.state().ordered(("j1", "j2")) == pytest.approx([0.1, 1.2])
    arm.jog((0, 0, 0.1)).result()
    assert arm.grasp_pose().position == pytest.approx([0.4, 0.1, 0.65])


def test_a_fake_arm_follows_a_trajectory_of_its_robots_own_joints():
    arm = own_arm()
    arm.execute(arm.plan_from_trajectory(Trajectory(("j1",), [0.0, 1.0], [[0.1], [0.5]])).result()).result()
    assert arm.state().ordered(("j1", "j2")) == pytest.approx([0.5, 0.2])


@pytest.mark.parametrize("what", ["goal", "start"])
def test_a_joint_that_a_fake_arm_lacks_is_refused_with_those_that_it_has(what):
    state = JointState(("j3",), [0.0])
    with pytest.raises(UnknownNameError, match="j3.*available: j1, j2, rx"):
        own_arm().plan(**{"goal": "home", what: state})


@pytest.mark.parametrize("closed", [[1.0, 0.5], [-1.0, 0.5], [-1.0, 0.0]])
def test_a_fake_hand_closes_as_its_postures_say_until_it_touches(closed):
    names, end = ("j1", "j2"), np.array(closed)
    start, thing = JointState(names, [0.0, 0.0]), JointState(names, 0.6 * end)
    hand = FakeHand(start, thing=thing, forces={"tip": 2.0}, closed=JointState(names, end))
    assert hand.move(JointState(names, 0.5 * end), 1.0).result().position == pytest.approx(0.5 * end)
    assert not hand.contacts()
    assert hand.move(JointState(names, end), 1.0).result().position == pytest.approx(0.6 * end)
    assert hand.contacts() == {"tip": 2.0}
    assert hand.move(start, 1.0).result().position == pytest.approx([0.0, 0.0])
    assert not hand.contacts()
