"""A legacy program in ROS 1's style whose machine runs until ROS is shut down."""

import sys
import time

from grip_bt import smach_compat

smach_compat.install()

import smach  # noqa: E402
import smach_ros  # noqa: E402


class Waits(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["done", "preempted"])

    def execute(self, userdata):
        sys.stdout.write("waiting\n")
        sys.stdout.flush()
        while not self.preempt_requested():
            time.sleep(0.01)
        self.service_preempt()
        return "preempted"


smach.set_loggers(*[lambda text: None] * 4)
sm = smach.StateMachine(outcomes=["done", "preempted"])
with sm:
    smach.StateMachine.add("WAIT", Waits())
smach_ros.set_preempt_handler(sm)
sys.stdout.write(sm.execute() + "\n")
