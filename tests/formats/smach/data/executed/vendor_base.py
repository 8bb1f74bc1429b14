"""Bases, messages and helpers of packages that only the robot has."""
import rospy
import tf2_ros
import smach
from vendor_robot.states import *
from vendor_robot.util import number_of_shelves

class Find(VendorState):
    def __init__(self, robot):
        VendorState.__init__(self, robot, outcomes=['found', 'lost'])

def machine(robot):
    frame = rospy.get_param('~frame', 'base_link')
    buffer = tf2_ros.Buffer(rospy.Duration(10.0) * 2)
    transitions = dict(zip(['found', 'lost'], ['TAKE', 'aborted']))
    sm = smach.StateMachine(outcomes=['done', 'aborted'])
    with sm:
        smach.StateMachine.add('FIND_' + frame.upper(), Find(robot), transitions)
        smach.StateMachine.add('TAKE', Take(robot, buffer), {'taken': 'done', 'failed': 'aborted'})
    return sm
