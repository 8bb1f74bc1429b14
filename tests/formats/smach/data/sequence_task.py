import smach

class Do(smach.State):
    def __init__(self, what):
        smach.State.__init__(self, outcomes=['succeeded', 'aborted', 'preempted'])
        self.what = what
    def execute(self, userdata):
        return 'aborted' if self.what == 'jump' else 'succeeded'

def get_sequence():
    seq = smach.Sequence(outcomes=['succeeded', 'aborted', 'preempted'], connector_outcome='succeeded')
    with seq:
        smach.Sequence.add('LIFT', Do('lift'))
        smach.Sequence.add('TURN', Do('turn'))
        smach.Sequence.add('JUMP', Do('jump'), transitions={'aborted': 'LAND'})
        smach.Sequence.add('LAND', Do('land'))
    return seq
