"""States from a product, a parsed text and a dictionary's order: nothing that a reader of the text follows."""
import itertools
import json
import smach

PLAN = json.loads('{"colours": ["red", "blue"], "sizes": ["small", "large"]}')

class Sort(smach.State):
    def __init__(self, colour, size):
        smach.State.__init__(self, outcomes=['sorted', 'jammed'], io_keys=['bins'])
        self.what = colour + ' ' + size
    def execute(self, userdata):
        userdata.bins = userdata.bins + [self.what]
        return 'sorted'

def build():
    sm = smach.StateMachine(outcomes=['succeeded', 'aborted'])
    sm.userdata.bins = []
    pairs = list(itertools.product(PLAN['colours'], PLAN['sizes']))
    labels = ['%s_%s' % (c.upper(), s.upper()) for c, s in pairs]
    with sm:
        for (colour, size), label, after in zip(pairs, labels, labels[1:] + ['succeeded']):
            smach.StateMachine.add(label, Sort(colour, size), {'sorted': after, 'jammed': 'aborted'})
    return sm
