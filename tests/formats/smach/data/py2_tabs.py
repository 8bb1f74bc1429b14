#!/usr/bin/env python
import smach

class Grip(smach.State):
	def __init__(self, force):
		smach.State.__init__(self, outcomes=["holds", "slips"], output_keys=["force"])
		self.force = force
	def execute(self, userdata):
                print "gripping with", self.force
		userdata.force = self.force
		if {"a": 1}.has_key("a") and self.force > 1:
			return "holds"
		return "slips"

def build():
	sm = smach.StateMachine(outcomes=["ok", "no"])
	with sm:
		for i in xrange(1, 3):
			smach.StateMachine.add("GRIP%d" % i, Grip(i), transitions={"holds": "ok", "slips": "no" if i == 2 else "GRIP2"})
	return sm
