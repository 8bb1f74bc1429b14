import rospy, smach
from smach_ros import MonitorState, ConditionState, ServiceState
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

def pressed(ud, msg):
    return not msg.data

def machine():
    sm = smach.StateMachine(outcomes=['done', 'failed', 'preempted'])
    with sm:
        smach.StateMachine.add('BUTTON', MonitorState('/button', Bool, pressed),
                               {'invalid': 'READY', 'valid': 'BUTTON'})
        smach.StateMachine.add('READY', ConditionState(lambda ud: True, max_checks=3),
                               {'true': 'TRIGGER', 'false': 'failed'})
        smach.StateMachine.add('TRIGGER', ServiceState('/trigger', Trigger, response_slots=['success', 'message']),
                               {'succeeded': 'done', 'aborted': 'failed'})
    return sm
