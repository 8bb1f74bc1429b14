"""Outcome lists put together, states that index them, a base class of one's own."""
import smach

BASE = ['done', 'error']

class Base(smach.State):
    EXTRA = []
    def __init__(self, name, more=()):
        super().__init__(outcomes=BASE + self.EXTRA + list(more), input_keys=['seen'], output_keys=['seen'])
        self.name = name
    def execute(self, userdata):
        userdata.seen = userdata.seen + [self.name]
        return self.decide()
    def decide(self):
        return 'done'

class Choose(Base):
    EXTRA = ['left', 'right']
    def decide(self):
        return 'right'

def build():
    machine = smach.StateMachine(outcomes=['finished', 'broken'])
    machine.userdata.seen = []
    errors = dict(error='broken')
    with machine:
        machine.add('CHOOSE', Choose('choose'), dict(errors, left='LEFT', right='RIGHT', done='finished'))
        machine.add('LEFT', Base('left'), dict(errors, done='finished'))
        machine.add('RIGHT', Base('right', more=['later']), dict(errors, done='finished', later='LEFT'))
    return machine
