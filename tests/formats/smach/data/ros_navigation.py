#!/usr/bin/env python
import roslib; roslib.load_manifest('courier')
import rospy
import smach
import smach_ros
from smach_ros import SimpleActionState, ServiceState
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_srvs.srv import Empty

def goal_cb(userdata, goal):
    goal.target_pose = userdata.pose
    return goal

class WaitForOrder(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['ordered', 'preempted'], output_keys=['pose'])

    def execute(self, userdata):
        while not rospy.is_shutdown():
            if self.preempt_requested():
                self.service_preempt()
                return 'preempted'
            rospy.sleep(0.1)
        return 'preempted'

def main():
    rospy.init_node('courier')
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted', 'preempted'])
    with sm:
        smach.StateMachine.add('WAIT', WaitForOrder(), transitions={'ordered': 'CLEAR'})
        smach.StateMachine.add('CLEAR', ServiceState('/move_base/clear_costmaps', Empty),
                               transitions={'succeeded': 'DRIVE', 'aborted': 'DRIVE'})
        smach.StateMachine.add('DRIVE',
                               SimpleActionState('move_base', MoveBaseAction, goal_cb=goal_cb, input_keys=['pose']),
                               transitions={'succeeded': 'WAIT'})
    sis = smach_ros.IntrospectionServer('courier', sm, '/COURIER')
    sis.start()
    sm.execute()
    rospy.spin()
    sis.stop()

if __name__ == '__main__':
    main()
