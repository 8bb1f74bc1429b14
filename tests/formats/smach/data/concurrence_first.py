"""A Concurrence that stops the others when one ends: no parallel does that by asking; it runs as one leaf."""
import smach

class Watch(smach.State):
    def __init__(self, ends):
        smach.State.__init__(self, outcomes=['seen', 'preempted'])
        self.ends = ends
    def execute(self, userdata):
        import time
        while not self.ends:
            if self.preempt_requested():
                self.service_preempt()
                return 'preempted'
            time.sleep(0.002)
        return 'seen'

def child_term_cb(outcome_map):
    return outcome_map['A'] == 'seen' or outcome_map['B'] == 'seen'

def create_state_machine():
    sm = smach.StateMachine(outcomes=['done', 'lost'])
    with sm:
        cc = smach.Concurrence(outcomes=['a', 'b', 'none'], default_outcome='none',
                               outcome_map={'a': {'A': 'seen'}, 'b': {'B': 'seen'}},
                               child_termination_cb=child_term_cb)
        with cc:
            smach.Concurrence.add('A', Watch(False))
            smach.Concurrence.add('B', Watch(True))
        smach.StateMachine.add('WATCH', cc, {'a': 'lost', 'b': 'done', 'none': 'lost'})
    return sm
