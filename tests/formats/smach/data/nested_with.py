"""Machines in machines, keys that go in and out under other names, constants of the level above."""
import smach

class Grow(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['grown', 'full'], input_keys=['size', 'limit'], output_keys=['size'])
    def execute(self, userdata):
        if userdata.size >= userdata.limit:
            return 'full'
        userdata.size += 1
        return 'grown'

class Judge(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['good', 'bad'], input_keys=['result'])
    def execute(self, userdata):
        return 'good' if userdata.result == 4 else 'bad'

def build():
    top = smach.StateMachine(outcomes=['succeeded', 'aborted'])
    top.userdata.width = 1
    top.userdata.maximum = 4
    with top:
        inner = smach.StateMachine(outcomes=['filled'], input_keys=['size', 'limit'], output_keys=['size'])
        with inner:
            smach.StateMachine.add('GROW', Grow(), transitions={'grown': 'GROW', 'full': 'filled'})
        smach.StateMachine.add('FILL', inner, transitions={'filled': 'JUDGE'},
                               remapping={'size': 'width', 'limit': 'maximum'})
        smach.StateMachine.add('JUDGE', Judge(), transitions={'good': 'succeeded', 'bad': 'aborted'},
                               remapping={'result': 'width'})
    return top
