"""A reference action server for programs of ROS 1: the goal's number says how it ends."""

import rospy
from actionlib.action_server import ActionServer
from actionlib.msg import TestAction, TestResult


class Reference(ActionServer):
    def __init__(self, name):
        ActionServer.__init__(self, name, TestAction, self.take, lambda handle: None, False)
        self.start()

    def take(self, handle):
        number = handle.get_goal().goal
        if number == 3:
            handle.set_rejected(None, "no threes")
            return
        handle.set_accepted()
        if number == 1:
            handle.set_succeeded(TestResult(10), "done")
        else:
            handle.set_aborted(None, "failed")


if __name__ == "__main__":
    rospy.init_node("reference")
    server = Reference("reference_action")
    rospy.spin()
