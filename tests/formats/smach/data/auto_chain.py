import smach

class Work(smach.State):
    def __init__(self, n):
        smach.State.__init__(self, outcomes=['next', 'skip', 'stop'], io_keys=['trace'])
        self.n = n
    def execute(self, userdata):
        userdata.trace = userdata.trace + [self.n]
        return 'skip' if self.n == 2 else 'next'

def make():
    sm = smach.StateMachine(outcomes=['end', 'stop'])
    sm.userdata.trace = []
    with sm:
        smach.StateMachine.add_auto('ONE', Work(1), ['next'], transitions={'skip': 'end'})
        smach.StateMachine.add_auto('TWO', Work(2), ['next', 'skip'])
        smach.StateMachine.add('THREE', Work(3), transitions={'next': 'end', 'skip': 'end'})
    return sm
