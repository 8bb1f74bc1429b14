#!/usr/bin/env python
import rospy
import smach
import smach_ros
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_srvs.srv import Trigger, TriggerRequest


def goal_of(userdata, default_goal):
    goal = MoveBaseGoal()
    goal.target_pose = userdata.pose
    return goal


def result_of(userdata, status, result):
    userdata.reached = True
    return 'succeeded'


def main():
    rospy.init_node('fetcher')
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted', 'preempted'], input_keys=['pose'], output_keys=['reached'])
    with sm:
        smach.StateMachine.add('RESET', smach_ros.ServiceState('reset', Trigger, request=TriggerRequest()),
                               transitions={'succeeded': 'GO'})
        smach.StateMachine.add('GO', smach_ros.SimpleActionState('move_base', MoveBaseAction, goal_cb=goal_of,
                                                                 result_cb=result_of, input_keys=['pose'],
                                                                 output_keys=['reached']),
                               {'aborted': 'BACK'})
        smach.StateMachine.add('BACK', smach_ros.SimpleActionState('move_base', MoveBaseAction, goal=MoveBaseGoal()),
                               {'succeeded': 'aborted'})
    wrapper = smach_ros.ActionServerWrapper('fetch', MoveBaseAction, sm, ['succeeded'], ['aborted'], ['preempted'])
    wrapper.run_server()
    rospy.spin()


if __name__ == '__main__':
    main()
