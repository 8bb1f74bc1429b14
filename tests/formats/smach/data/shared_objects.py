"""Objects that only the building function knows, shared by states: taken from the built machine."""
import smach

class Store(object):
    def __init__(self):
        self.things = []

class Put(smach.State):
    def __init__(self, store, thing):
        smach.State.__init__(self, outcomes=['stored'])
        self.store, self.thing = store, thing
    def execute(self, userdata):
        self.store.things.append(self.thing)
        return 'stored'

class Count(smach.State):
    def __init__(self, store):
        smach.State.__init__(self, outcomes=['two', 'other'], input_keys=['offset'])
        self.store = store
    def execute(self, userdata):
        return 'two' if len(self.store.things) + userdata.offset.value == 2 else 'other'

class Offset(object):
    def __init__(self, value):
        self.value = value

def build():
    store = Store()
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted'])
    sm.userdata.offset = Offset(0)
    with sm:
        smach.StateMachine.add('PUT_A', Put(store, 'a'), {'stored': 'PUT_B'})
        smach.StateMachine.add('PUT_B', Put(store, 'b'), {'stored': 'COUNT'})
        smach.StateMachine.add('COUNT', Count(store), {'two': 'succeeded', 'other': 'aborted'})
    return sm
