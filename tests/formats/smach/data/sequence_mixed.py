import smach


@smach.cb_interface(input_keys=['count'], output_keys=['count'], outcomes=['succeeded', 'aborted'])
def add_one(userdata):
    userdata.count = userdata.count + 1
    return 'succeeded'


class Check(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['succeeded', 'aborted', 'again'], input_keys=['count'])

    def execute(self, userdata):
        return 'again' if userdata.count < 5 else 'succeeded'


def build():
    seq = smach.Sequence(outcomes=['succeeded', 'aborted'], connector_outcome='succeeded')
    seq.userdata.count = 0
    with seq:
        smach.Sequence.add('ADD', smach.CBState(add_one))
        smach.Sequence.add('ADD_AGAIN', smach.CBState(add_one))
        smach.Sequence.add('CHECK', Check(), transitions={'again': 'ADD'})
    return seq
