import smach
from smach import CBState, cb_interface

@cb_interface(outcomes=['finished'], output_keys=['items'])
def fill(userdata):
    userdata.items = [1, 2, 3]
    return 'finished'

@cb_interface(outcomes=['more', 'empty'], input_keys=['items', 'total'], output_keys=['total', 'items'])
def take(userdata, factor, offset=0):
    if not userdata.items:
        return 'empty'
    first, rest = userdata.items[0], userdata.items[1:]
    userdata.total = userdata.total + factor * first + offset
    userdata.items = rest
    return 'more'

def report(ud):
    return 'big' if ud.value > 10 else 'small'

sm = smach.StateMachine(outcomes=['big', 'small'])
sm.userdata.total = 0
with sm:
    smach.StateMachine.add('FILL', CBState(fill), {'finished': 'TAKE'})
    smach.StateMachine.add('TAKE', CBState(take, cb_args=[2], cb_kwargs={'offset': 1}), {'more': 'TAKE', 'empty': 'REPORT'})
    smach.StateMachine.add('REPORT', CBState(report, outcomes=['big', 'small'], input_keys=['value']),
                           remapping={'value': 'total'})
