import smach


class Load(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['loaded'], input_keys=['boxes', 'limits'], output_keys=['boxes'])

    def execute(self, userdata):
        userdata.boxes = userdata.boxes + userdata.limits['step']
        return 'loaded'


def build():
    sm = smach.StateMachine(outcomes=['loaded'])
    data = smach.UserData()
    data.boxes = 4
    data.limits = {'step': 2, 'most': 9}
    sm.userdata = data
    with sm:
        smach.StateMachine.add('LOAD', Load(), {'loaded': 'AGAIN'})
        smach.StateMachine.add('AGAIN', Load())
    return sm
