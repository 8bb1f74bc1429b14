import smach

class A(smach.State):
    def __init__(self):
        smach.State.__init__(self, ['x', 'y'])
    def execute(self, ud):
        return 'x'

def build():
    sm = smach.StateMachine(['x', 'y'])
    sm.set_initial_state(['SECOND'])
    with sm:
        smach.StateMachine.add('FIRST', A(), {'x': 'y', 'y': 'x'})
        smach.StateMachine.add('SECOND', A(), {'y': 'FIRST'})
    return sm
