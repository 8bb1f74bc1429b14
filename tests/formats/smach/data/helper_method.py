import smach


class Do(smach.State):
    def __init__(self, what):
        smach.State.__init__(self, outcomes=['done', 'failed'])
        self.what = what

    def execute(self, userdata):
        return 'done'


class Plan(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['done', 'failed'])
        with self:
            self._step('OPEN', 'open', 'TAKE')
            self._step('TAKE', 'take', 'CLOSE')
            self._step('CLOSE', 'close', 'done')

    def _step(self, label, what, following):
        smach.StateMachine.add(label, Do(what), transitions={'done': following, 'failed': 'failed'})


def build():
    return Plan()
