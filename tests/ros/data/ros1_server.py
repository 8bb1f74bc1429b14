"""A ROS 1 program: a service, an action, a topic and a frame; nothing in it knows that ROS 2 is below."""

import sys

from grip_bt import smach_compat

smach_compat.install(rospy=True)

from std_srvs.srv import SetBool, SetBoolResponse  # noqa: E402, I001 - before rospy, as some programs do

import actionlib  # noqa: E402
import rospy  # noqa: E402
import tf  # noqa: E402
from counting_interfaces.msg import CountAction, CountFeedback, CountResult  # noqa: E402
from geometry_msgs.msg import Point, PointStamped  # noqa: E402
from std_msgs.msg import Header  # noqa: E402


class Counts:
    def __init__(self):
        self.server = actionlib.SimpleActionServer("count", CountAction, self.execute, auto_start=False)
        self.server.start()

    def execute(self, goal):
        self.server.publish_feedback(CountFeedback(goal.goal))
        while goal.goal == 4 and not self.server.is_preempt_requested():
            rospy.sleep(0.01)
        if goal.goal == 4:
            self.server.set_preempted()
        elif goal.goal == 2:
            self.server.set_aborted()
        else:
            self.server.set_succeeded(CountResult(10 * goal.goal))


rospy.init_node("ros1_server")
counts = Counts()
service = rospy.Service("answer", SetBool, lambda request: SetBoolResponse(request.data, "as you say"))
refused = rospy.Service("refuse", SetBool, lambda request: 1 / 0)
publisher = rospy.Publisher("/where", PointStamped, queue_size=1)
broadcaster = tf.TransformBroadcaster()
sys.stdout.write("serving\n")
sys.stdout.flush()
rate = rospy.Rate(20)
while not rospy.is_shutdown():
    publisher.publish(Header(stamp=rospy.Time.now(), frame_id="map"), Point(1.0, 2.0, 3.0))
    broadcaster.sendTransform(
        (0.0, 0.0, 1.0), tf.transformations.quaternion_from_euler(0, 0, 1.5), rospy.Time.now(), "hand", "map"
    )
    rate.sleep()
