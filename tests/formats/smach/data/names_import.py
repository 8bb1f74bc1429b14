from smach import State, StateMachine, Concurrence
from smach_ros import *
from robot_skills.arms import GripperState

import vendor_speech as speech


class Open(State):
    def __init__(self, robot, timeout=3.0):
        State.__init__(self, outcomes=['opened', 'failed'])
        self.robot, self.timeout = robot, timeout

    def execute(self, userdata):
        self.robot.arm.send_gripper_goal(GripperState.OPEN)
        return 'opened'


class Tell(State):
    def __init__(self, robot):
        State.__init__(self, outcomes=['told'])
        self.robot = robot

    def execute(self, userdata):
        self.robot.speech.speak(speech.greeting())
        return 'told'


class OpenAndTell(StateMachine):
    def __init__(self, robot):
        StateMachine.__init__(self, outcomes=['succeeded', 'failed'])
        with self:
            StateMachine.add('OPEN', Open(robot), transitions={'opened': 'BOTH', 'failed': 'failed'})
            both = Concurrence(outcomes=['succeeded', 'failed'], default_outcome='failed',
                               outcome_map={'succeeded': {'OPEN_AGAIN': 'opened', 'TELL': 'told'}})
            with both:
                Concurrence.add('OPEN_AGAIN', Open(robot, timeout=1.0))
                Concurrence.add('TELL', Tell(robot))
            StateMachine.add('BOTH', both)
