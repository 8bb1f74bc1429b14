from smach import State

class Pour(State):
    def __init__(self, amount=0.1):
        State.__init__(self, outcomes=['poured', 'spilled'], io_keys=['level'])
        self.amount = amount
    def execute(self, userdata):
        userdata.level = round(userdata.level + self.amount, 3)
        return 'poured'

class IsFull(State):
    def __init__(self):
        State.__init__(self, outcomes=['full', 'not_full'], input_keys=['level'])
    def execute(self, userdata):
        return 'full' if userdata.level >= 0.3 else 'not_full'
