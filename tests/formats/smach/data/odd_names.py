"""Labels and outcomes that a task spells in another way, and a state called as an outcome is."""
import smach

class S(smach.State):
    def __init__(self, result):
        smach.State.__init__(self, outcomes=['1st', 'not.ok'])
        self.result = result
    def execute(self, ud):
        return self.result

def build():
    sm = smach.StateMachine(outcomes=['done', 'err/or'])
    with sm:
        smach.StateMachine.add('a.b', S('1st'), {'1st': 'done', 'not.ok': 'err/or'})
        smach.StateMachine.add('done', S('not.ok'), {'1st': 'a.b', 'not.ok': 'err/or'})
    return sm
