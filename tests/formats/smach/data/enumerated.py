import smach

PLACES = [('KITCHEN', 1.0), ('HALL', 2.5), ('DOOR', 4.0)]


class Drive(smach.State):
    def __init__(self, x):
        smach.State.__init__(self, outcomes=['arrived', 'blocked'])
        self.x = x

    def execute(self, userdata):
        return 'arrived'


def build():
    sm = smach.StateMachine(outcomes=['arrived', 'blocked'])
    with sm:
        for i, (name, x) in enumerate(PLACES):
            following = PLACES[i + 1][0] if i + 1 < len(PLACES) else 'arrived'
            smach.StateMachine.add('GO_' + name if False else name, Drive(x), transitions={'arrived': following})
    return sm
