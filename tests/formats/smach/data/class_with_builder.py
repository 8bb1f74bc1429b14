import rospy
import smach
import actionlib
from vendor_msgs.msg import ArmAction, ArmGoal
from smach_ros import SimpleActionState

class TaskNode(object):
    def __init__(self):
        rospy.init_node('task')
        self.client = actionlib.SimpleActionClient('arm', ArmAction)
        self.sm = smach.StateMachine(outcomes=['succeeded', 'aborted', 'preempted'])
        self.sm.userdata.goal = ArmGoal()
        with self.sm:
            smach.StateMachine.add('MOVE', SimpleActionState('arm', ArmAction, goal_key='goal'),
                                   transitions={'succeeded': 'CHECK'})
            smach.StateMachine.add('CHECK', smach.CBState(self.check, outcomes=['ok', 'again']),
                                   transitions={'ok': 'succeeded', 'again': 'MOVE'})

    def check(self, userdata):
        return 'ok' if self.client.get_state() == 3 else 'again'

    def run(self):
        return self.sm.execute()

if __name__ == '__main__':
    TaskNode().run()
