from smach import *
from math import *

class Approach(State):
    def __init__(self, step=0.25):
        super(Approach, self).__init__(outcomes=['near', 'far'], io_keys=['distance'])
        self._step = step

    def execute(self, userdata):
        userdata.distance -= self._step
        return 'near' if fabs(userdata.distance) < 0.3 else 'far'

machine = StateMachine(outcomes=['done'])
machine.userdata.distance = 1.0
with machine:
    StateMachine.add('APPROACH', Approach(), transitions={'near': 'done', 'far': 'APPROACH'})
