#!/usr/bin/env python
# Python 2: print statements, old excepts, has_key and xrange
import smach

class Count(smach.State):
	def __init__(self, limit):
		smach.State.__init__(self, outcomes=['again', 'done'], input_keys=['n'], output_keys=['n'])
		self.limit = limit

	def execute(self, ud):
		print 'counting', ud.n
		table = {}
		for i in xrange(ud.n):
			table[i] = i * 2
		if table.has_key(self.limit):
			return 'done'
		ud.n = ud.n + 1
		return 'again'

class Check(smach.State):
        def __init__(self):
                smach.State.__init__(self, outcomes=['ok', 'bad'], input_keys=['count_in'])

        def execute(self, ud):
                try:
                        value = int(ud.count_in)
                except ValueError, e:
                        print >>None, 'no number:', e
                        return 'bad'
                return 'ok'

def create():
        sm = smach.StateMachine(outcomes=['succeeded', 'failed'])
        sm.userdata.n = 0
        with sm:
                smach.StateMachine.add('COUNT', Count(3), {'again': 'COUNT', 'done': 'CHECK'})
                smach.StateMachine.add('CHECK', Check(), {'ok': 'succeeded', 'bad': 'failed'},
                                       remapping={'count_in': 'n'})
        return sm

if __name__ == '__main__':
        print create().execute()
