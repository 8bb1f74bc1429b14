import smach

class Try(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['got', 'nothing'], output_keys=['thing'])
    def execute(self, ud):
        return 'nothing'

class Use(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['used', 'missing'], input_keys=['thing', 'extra'])
    def execute(self, ud):
        return 'used' if 'thing' in ud or 'extra' in ud else 'missing'

def build():
    sm = smach.StateMachine(outcomes=['yes', 'no'], input_keys=['extra'])
    with sm:
        smach.StateMachine.add('TRY', Try(), {'got': 'USE', 'nothing': 'USE'})
        smach.StateMachine.add('USE', Use(), {'used': 'yes', 'missing': 'no'})
    return sm
