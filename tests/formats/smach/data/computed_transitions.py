import smach

OUTCOMES = ['left', 'right', 'ahead']
TARGETS = dict(zip(OUTCOMES, ['TURN', 'TURN', 'end']))


class Choose(smach.State):
    def __init__(self):
        super(Choose, self).__init__(outcomes=OUTCOMES)
        self._turns = 0

    def execute(self, ud):
        self._turns += 1
        return OUTCOMES[min(self._turns - 1, 2)]


class Turn(smach.State):
    def __init__(self):
        super(Turn, self).__init__(outcomes=['turned'])

    def execute(self, ud):
        return 'turned'


def build():
    sm = smach.StateMachine(outcomes=['end'])
    table = {}
    for outcome in OUTCOMES:
        table[outcome] = TARGETS[outcome]
    back = {'turned': 'CHOOSE'}
    with sm:
        smach.StateMachine.add('CHOOSE', Choose(), transitions=table)
        smach.StateMachine.add('TURN', Turn(), transitions=dict(back))
    return sm
