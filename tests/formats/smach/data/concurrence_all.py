import smach

class Sense(smach.State):
    def __init__(self, key, value):
        smach.State.__init__(self, outcomes=['succeeded', 'aborted'], output_keys=[key])
        self.key, self.value = key, value
    def execute(self, userdata):
        userdata[self.key] = self.value
        return 'succeeded'

class Compare(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['same', 'different'], input_keys=['left', 'right'])
    def execute(self, userdata):
        return 'same' if userdata.left == userdata.right else 'different'

def build():
    sm = smach.StateMachine(outcomes=['same', 'different', 'failed'])
    with sm:
        cc = smach.Concurrence(outcomes=['both', 'not_both'], default_outcome='not_both', output_keys=['left', 'right'],
                               outcome_map={'both': {'LEFT': 'succeeded', 'RIGHT': 'succeeded'}})
        with cc:
            smach.Concurrence.add('LEFT', Sense('left', 3))
            smach.Concurrence.add('RIGHT', Sense('right', 4))
        smach.StateMachine.add('SENSE', cc, transitions={'both': 'COMPARE', 'not_both': 'failed'})
        smach.StateMachine.add('COMPARE', Compare())
    return sm
