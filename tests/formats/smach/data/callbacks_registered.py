import smach


def started(userdata, initial_states, *args):
    print('start', initial_states)


def moved(userdata, active_states, *args):
    print('now', active_states)


class Step(smach.State):
    def __init__(self, outcomes=('next',)):
        smach.State.__init__(self, outcomes=list(outcomes), io_keys=['n'])

    def execute(self, userdata):
        userdata.n += 1
        return 'next'


def build():
    sm = smach.StateMachine(['stop'])
    sm.userdata.n = 0
    sm.register_start_cb(started)
    sm.register_transition_cb(moved, cb_args=[])
    with sm:
        smach.StateMachine.add('A', Step(), {'next': 'B'})
        smach.StateMachine.add('B', Step(), {'next': 'stop'})
    return sm
