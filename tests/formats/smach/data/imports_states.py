import smach
from states_lib import Pour, IsFull
import states_lib as lib

class Fill(smach.StateMachine):
    def __init__(self, amount=0.1):
        super(Fill, self).__init__(outcomes=['full', 'failed'], input_keys=['level'], output_keys=['level'])
        self.userdata.level = 0.0
        with self:
            self.add('POUR', Pour(amount), {'poured': 'CHECK', 'spilled': 'failed'})
            self.add('CHECK', lib.IsFull(), {'full': 'full', 'not_full': 'POUR'})
