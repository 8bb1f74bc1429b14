"""Importing does more than build: it writes, starts programs, prints, waits for input and exits."""
import os
import subprocess
import sys
import time
import smach

class Stop(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['stopped'])
    def execute(self, userdata):
        raise RuntimeError('a recorded machine is not executed')

sm = smach.StateMachine(outcomes=['stopped'])
with sm:
    for label in sorted(set(['STOP'])):
        smach.StateMachine.add(label, Stop())
print('{"containers": "nonsense"}')
time.sleep(3600)
sm.execute()
for attempt in (lambda: open(os.environ['GRIP_TEST_FILE'], 'w'), lambda: subprocess.call(['touch', os.environ['GRIP_TEST_FILE']]),
                lambda: os.open(os.environ['GRIP_TEST_FILE'], os.O_CREAT)):
    try:
        attempt()
    except OSError:
        pass
sys.exit(3)
