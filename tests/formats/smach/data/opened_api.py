import smach

class Wait(smach.State):
    def __init__(self, n):
        smach.State.__init__(self, outcomes=('over',) and ['over'])
        self.n = n
    def execute(self, ud):
        return 'over'

def build():
    sm = smach.StateMachine(outcomes=['over'])
    with sm.opened():
        sm.add('W1', Wait(1), {'over': 'W2'})
    sm.open()
    smach.StateMachine.add('W2', Wait(2), {'over': 'over'})
    sm.close()
    return sm
