import smach

class Clean(smach.State):
    def __init__(self, room):
        smach.State.__init__(self, outcomes=['clean', 'stuck'], output_keys=['last'])
        self.room = room
    def execute(self, userdata):
        userdata.last = self.room
        return 'clean'

class CleanAll(smach.StateMachine):
    def __init__(self, rooms, finally_='succeeded'):
        smach.StateMachine.__init__(self, outcomes=['succeeded', 'aborted'], output_keys=['last'])
        with self:
            for room, after in zip(rooms, [r.upper() for r in rooms[1:]] + [finally_]):
                self.add(room.upper(), Clean(room), {'clean': after, 'stuck': 'aborted'})
