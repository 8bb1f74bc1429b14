import smach

class Give(smach.State):
    def __init__(self, answer):
        smach.State.__init__(self, outcomes=['left', 'right', 'none'])
        self.answer = answer
    def execute(self, ud):
        return self.answer

class Both(smach.Concurrence):
    def __init__(self, first='none', second='right'):
        smach.Concurrence.__init__(self, outcomes=['go_left', 'go_right', 'stay'], default_outcome='stay',
                                   outcome_map={'go_left': {'FIRST': 'left'}, 'go_right': {'SECOND': 'right'}})
        with self:
            smach.Concurrence.add('FIRST', Give(first))
            smach.Concurrence.add('SECOND', Give(second))

def build():
    sm = smach.StateMachine(outcomes=['went', 'stayed'])
    with sm:
        smach.StateMachine.add('DECIDE', Both(), transitions={'go_left': 'went', 'go_right': 'went', 'stay': 'stayed'})
    return sm
