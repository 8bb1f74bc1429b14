import smach


class Fetch(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['fetched', 'missing'], input_keys=['item', 'found'], output_keys=['found'])

    def execute(self, userdata):
        userdata.found = userdata.found + [userdata.item]
        return 'missing' if userdata.item == 'fork' else 'fetched'


def build():
    sm = smach.StateMachine(outcomes=['done', 'gave_up'])
    sm.userdata.found = []
    with sm:
        it = smach.Iterator(outcomes=['all', 'gave_up'], input_keys=['found'], output_keys=['found'],
                            it=lambda: ['cup', 'plate', 'fork', 'spoon'], it_label='item', exhausted_outcome='all')
        with it:
            inner = smach.StateMachine(outcomes=['fetched', 'missing'], input_keys=['item', 'found'], output_keys=['found'])
            with inner:
                smach.StateMachine.add('FETCH', Fetch())
            smach.Iterator.set_contained_state('ONE', inner, loop_outcomes=['fetched'],
                                               final_outcome_map={'missing': 'gave_up'})
        smach.StateMachine.add('EACH', it, {'all': 'done', 'gave_up': 'gave_up'})
    return sm
