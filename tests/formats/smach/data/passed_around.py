"""The machine is passed to functions that fill it."""
import smach

class Step(smach.State):
    def __init__(self, name):
        smach.State.__init__(self, outcomes=['ok', 'failed'], output_keys=['last'])
        self.name = name

    def execute(self, ud):
        ud.last = self.name
        return 'ok'

def add_pick(sm, following):
    sm.add('OPEN', Step('open'), transitions={'ok': 'CLOSE', 'failed': 'aborted'})
    sm.add('CLOSE', Step('close'), transitions={'ok': following, 'failed': 'aborted'})

def add_place(machine, prefix='PLACE'):
    with machine:
        smach.StateMachine.add(prefix + '_DOWN', Step('down'), transitions={'ok': prefix + '_AWAY', 'failed': 'aborted'})
        smach.StateMachine.add(prefix + '_AWAY', Step('away'), transitions={'ok': 'succeeded', 'failed': 'aborted'})

def build_all():
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted'])
    with sm:
        add_pick(sm, 'PLACE_DOWN')
    add_place(sm)
    return sm

if __name__ == '__main__':
    sm = build_all()
    sm.execute()
