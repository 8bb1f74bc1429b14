try:
    import rospy
    import smach_ros
    ROS = True
except ImportError:
    ROS = False
import smach


class Wait(smach.State):
    def __init__(self, seconds=1.0):
        smach.State.__init__(self, outcomes=['waited', 'preempted'])
        self.seconds = seconds

    def execute(self, ud):
        if self.preempt_requested():
            self.service_preempt()
            return 'preempted'
        return 'waited'


def build():
    machine = smach.StateMachine(outcomes=['waited', 'preempted'])
    with machine:
        smach.StateMachine.add('FIRST', Wait(), transitions={'waited': 'SECOND'})
        smach.StateMachine.add('SECOND', Wait(seconds=2.0))
    return machine
