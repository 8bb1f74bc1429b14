"""One userdata for two levels, by hand."""
import smach

class Write(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['ok'], output_keys=['mark'])
    def execute(self, userdata):
        userdata.mark = 'x'
        return 'ok'

class Inner(smach.StateMachine):
    def __init__(self, userdata):
        smach.StateMachine.__init__(self, outcomes=['ok'])
        self.userdata = userdata
        with self:
            smach.StateMachine.add('WRITE', Write(), {'ok': 'ok'})

def build():
    sm = smach.StateMachine(outcomes=['ok'])
    with sm:
        smach.StateMachine.add('INNER', Inner(sm.userdata), {'ok': 'ok'})
    return sm
