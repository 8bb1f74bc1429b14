"""`rospy`, `actionlib` and `tf` over real rclpy: a program of ROS 1 serves in another process, one here asks it."""

import pytest
from patience import PATIENCE

from grip_bt import smach_compat
from grip_bt.smach_compat import smach_ros

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def program(interface_cache):
    """Start the server; connect this process, which has ROS 1's modules meanwhile."""
    from pathlib import Path

    from ros_bench import servers

    from grip_bt.ros.environment import free_domain
    from grip_bt.ros.interfaces import build_interfaces
    from grip_bt.ros.interfaces.build import ensure_package
    from grip_bt.ros.interfaces.packages import activate
    from grip_bt.ros.smach_rclpy import connect

    (built,) = build_interfaces(Path(__file__).parent / "data" / "counting", interface_cache)
    activate(built.prefix)
    tf2 = ensure_package("tf2_msgs", interface_cache)
    with free_domain() as domain, servers(domain) as start:
        start("ros1_server.py", overlays=[built.prefix, *tf2])
        connection = connect(domain, interface_cache)
        smach_compat.install(rospy=True)
        smach_ros.use(connection)
        yield
        smach_ros.use(None)
        connection.close()
        smach_compat.uninstall()


def test_a_service_of_ros_1_is_called_with_fields_or_a_request(program):
    import rospy
    from std_srvs.srv import SetBool, SetBoolRequest

    rospy.wait_for_service("answer", timeout=PATIENCE)
    ask = rospy.ServiceProxy("answer", SetBool)
    ask.wait_for_service(PATIENCE)
    assert (ask(True).success, ask(data=False).success, ask(SetBoolRequest(True)).message) == (
        True,
        False,
        "as you say",
    )
    with pytest.raises(rospy.ROSException, match="timeout exceeded"):
        rospy.wait_for_service("nobody", timeout=0.1)


def test_goals_end_with_the_numbers_of_ros_1(program):
    import actionlib
    import rospy
    from actionlib_msgs.msg import GoalStatus
    from counting_interfaces.msg import CountAction, CountGoal

    client = actionlib.SimpleActionClient("count", CountAction)
    assert client.wait_for_server(rospy.Duration(PATIENCE))
    ended = [client.send_goal_and_wait(CountGoal(number), rospy.Duration(PATIENCE)) for number in (1, 2)]
    assert ended == [GoalStatus.SUCCEEDED, GoalStatus.ABORTED]
    told = []
    client.send_goal(CountGoal(4), done_cb=lambda status, result: told.append((status, result.result)))
    assert not client.wait_for_result(rospy.Duration(0.2))
    client.cancel_goal()
    assert client.wait_for_result(rospy.Duration(PATIENCE))
    assert (told, client.get_state()) == ([(GoalStatus.PREEMPTED, 0)], GoalStatus.PREEMPTED)


def test_an_action_state_hands_its_callback_the_number_that_ros_1_has(program):
    import smach
    from actionlib import GoalStatus
    from counting_interfaces.msg import CountAction, CountGoal

    seen = []
    state = smach_ros.SimpleActionState(
        "count",
        CountAction,
        goal=CountGoal(1),
        result_cb=lambda ud, status, result: seen.append((status, result.result)),
    )
    assert state.execute(smach.UserData()) == "succeeded"
    assert seen == [(GoalStatus.SUCCEEDED, 10)]


def test_messages_carry_times_that_can_be_reckoned_with(program):
    import rospy
    from geometry_msgs.msg import PointStamped

    message = rospy.wait_for_message("where", PointStamped, timeout=PATIENCE)
    age = rospy.Time.now() - message.header.stamp
    assert -1.0 < age.to_sec() < PATIENCE
    assert age < rospy.Duration(PATIENCE)
    assert (message.point.x, message.header.stamp.secs) == (1.0, message.header.stamp.sec)


def test_frames_are_found_and_points_are_brought_into_them(program):
    import rospy
    import tf
    from geometry_msgs.msg import PointStamped

    listener = tf.TransformListener()
    listener.waitForTransform("map", "hand", rospy.Time(0), rospy.Duration(PATIENCE))
    move, turn = listener.lookupTransform("map", "hand", rospy.Time(0))
    assert move == pytest.approx((0, 0, 1))
    assert tf.transformations.euler_from_quaternion(turn) == pytest.approx((0, 0, 1.5))
    point = PointStamped()
    point.header.frame_id, point.point.z = "hand", 1.0
    assert listener.transformPoint("map", point).point.z == pytest.approx(2.0)
    with pytest.raises(tf.LookupException):
        listener.lookupTransform("map", "nowhere", rospy.Time(0))
