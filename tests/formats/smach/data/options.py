"""Which states there are hangs on a parameter of the robot."""
import rospy
import smach
from smach_ros import SimpleActionState
from arm_msgs.msg import GripAction

class Plan(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['planned', 'no_plan'])
    def execute(self, userdata):
        return 'planned'

def main():
    rospy.init_node('options')
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted', 'preempted'])
    with sm:
        smach.StateMachine.add('PLAN', Plan(), {'planned': 'GRIP', 'no_plan': 'aborted'})
        if rospy.get_param('~calibrate', False):
            smach.StateMachine.add('CALIBRATE', SimpleActionState('calibrate', GripAction), {'succeeded': 'PLAN'})
        smach.StateMachine.add('GRIP', SimpleActionState('grip', GripAction))
    sm.execute()

if __name__ == '__main__':
    main()
