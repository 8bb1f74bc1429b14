import smach


class Say(smach.State):
    def __init__(self, sentence, block=True):
        smach.State.__init__(self, outcomes=['spoken'])
        self.sentence = sentence

    def execute(self, userdata=None):
        return 'spoken'


class Greet(smach.StateMachine):
    def __init__(self, polite=True, twice=False):
        smach.StateMachine.__init__(self, outcomes=['done'])
        with self:
            if polite:
                smach.StateMachine.add('BOW', Say('hello'), transitions={'spoken': 'TALK'})
            if twice:
                smach.StateMachine.add('TALK', Say('hi'), transitions={'spoken': 'TALK2'})
                smach.StateMachine.add('TALK2', Say('hi again'), transitions={'spoken': 'done'})
            else:
                smach.StateMachine.add('TALK', Say('hi'), transitions={'spoken': 'done'})


class Party(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['over'])
        with self:
            smach.StateMachine.add('FIRST', Greet(), transitions={'done': 'SECOND'})
            smach.StateMachine.add('SECOND', Greet(polite=False, twice=True), transitions={'done': 'over'})


def build():
    return Party()
