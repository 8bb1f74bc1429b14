"""Way points from the parameter server: how many states there are is known by a run only."""
import rospy
import smach
from nav_states import DriveTo

def build():
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted'])
    points = rospy.get_param('~points')
    with sm:
        for i, point in enumerate(points):
            smach.StateMachine.add('P%d' % i, DriveTo(point), {'succeeded': 'P%d' % (i + 1)})
    return sm
