import smach
from smach import Iterator, StateMachine, CBState, cb_interface

@cb_interface(input_keys=['shelf', 'found_at'], output_keys=['found_at'], outcomes=['found', 'empty'])
def search(ud):
    if ud.shelf == 'middle':
        ud.found_at = ud.shelf
        return 'found'
    return 'empty'

def build():
    sm = StateMachine(outcomes=['succeeded', 'aborted'])
    sm.userdata.found_at = ''
    with sm:
        it = Iterator(outcomes=['found', 'nothing'], input_keys=['found_at'], output_keys=['found_at'],
                      it=['low', 'middle', 'high'], it_label='shelf', exhausted_outcome='nothing')
        with it:
            Iterator.set_contained_state('SEARCH', CBState(search), loop_outcomes=['empty'])
        StateMachine.add('SEARCH_ALL', it, {'found': 'succeeded', 'nothing': 'aborted'})
    return sm
