"""Adds in loops over literal ranges, lists and dictionaries; labels from formats."""
import smach

ROOMS = ['kitchen', 'hall', 'office']
SPEEDS = {'kitchen': 0.3, 'hall': 0.8, 'office': 0.5}

class Visit(smach.State):
    def __init__(self, room, speed):
        smach.State.__init__(self, outcomes=['visited', 'blocked'], io_keys=['log'])
        self.room, self.speed = room, speed

    def execute(self, userdata):
        userdata.log.append((self.room, self.speed))
        return 'visited'

class Beep(smach.State):
    def __init__(self, times):
        smach.State.__init__(self, ['ok'])
        self.times = times

    def execute(self, userdata):
        return 'ok'

def create_patrol():
    sm = smach.StateMachine(['succeeded', 'aborted'])
    sm.userdata.log = []
    with sm:
        for i, room in enumerate(ROOMS):
            following = 'VISIT_%s' % ROOMS[i + 1].upper() if i + 1 < len(ROOMS) else 'BEEP_0'
            smach.StateMachine.add('VISIT_%s' % room.upper(), Visit(room, SPEEDS[room]),
                                   transitions={'visited': following, 'blocked': 'aborted'})
        for n in range(3):
            target = {'ok': 'BEEP_{}'.format(n + 1)} if n < 2 else {'ok': 'succeeded'}
            smach.StateMachine.add('BEEP_' + str(n), Beep(n), target)
    return sm
