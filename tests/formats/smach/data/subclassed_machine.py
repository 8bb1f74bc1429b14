"""A machine as a class, as most laboratories write them: states get the robot, which is passed down."""
import smach

class Say(smach.State):
    def __init__(self, robot, sentence, outcomes=['spoken']):
        smach.State.__init__(self, outcomes=outcomes)
        self.robot = robot
        self.sentence = sentence

    def execute(self, userdata=None):
        self.robot.said.append(self.sentence)
        return 'spoken'

class Ask(smach.State):
    def __init__(self, robot, answers):
        smach.State.__init__(self, outcomes=['heard', 'timeout'], output_keys=['name'])
        self.robot = robot
        self.answers = list(answers)

    def execute(self, userdata):
        answer = self.answers.pop(0)
        if not answer:
            return 'timeout'
        userdata.name = answer
        return 'heard'

class Robot(object):
    def __init__(self):
        self.said = []

class Meet(smach.StateMachine):
    def __init__(self, robot):
        smach.StateMachine.__init__(self, outcomes=['met', 'unknown'], output_keys=['name'])
        with self:
            smach.StateMachine.add('GREET', Say(robot, 'Hello'), transitions={'spoken': 'ASK'})
            smach.StateMachine.add('ASK', Ask(robot, ['', 'Ada']),
                                   transitions={'heard': 'met', 'timeout': 'AGAIN'})
            smach.StateMachine.add('AGAIN', Say(robot, 'Pardon?'), transitions={'spoken': 'ASK'})

class Party(smach.StateMachine):
    def __init__(self, robot=None):
        smach.StateMachine.__init__(self, outcomes=['Done', 'Aborted'])
        robot = robot or Robot()
        with self:
            smach.StateMachine.add('MEET', Meet(robot), transitions={'met': 'THANK', 'unknown': 'Aborted'})
            smach.StateMachine.add('THANK', Say(robot, 'Thank you'), transitions={'spoken': 'Done'})

if __name__ == '__main__':
    Party(Robot()).execute()
