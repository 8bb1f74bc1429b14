"""States that know each other, a state that is a variable of the module, and userdata made anew."""
import smach

class Counter(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['counted'])
        self.count = 0
    def execute(self, userdata):
        self.count += 1
        return 'counted'

class Limit(smach.State):
    def __init__(self, counter, limit=2):
        smach.State.__init__(self, outcomes=['below', 'reached'], input_keys=['more'])
        self.counter, self.limit = counter, limit
    def execute(self, userdata):
        return 'reached' if self.counter.count >= self.limit + userdata.more else 'below'

class Greet(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['hello'])
    def execute(self, userdata):
        return 'hello'

greet = Greet()

def build():
    sm = smach.StateMachine(outcomes=['done'])
    sm.userdata = smach.UserData()
    sm.userdata.more = 1
    counter = Counter()
    limit = Limit(counter)
    with sm:
        smach.StateMachine.add('GREET', greet, {'hello': 'COUNT'})
        smach.StateMachine.add('COUNT', counter, {'counted': 'LIMIT'})
        smach.StateMachine.add('LIMIT', limit, {'below': 'COUNT', 'reached': 'done'})
    return sm
