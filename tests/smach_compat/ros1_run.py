"""Runs files written for ROS 1 as they are, in this process, on `smach_compat` with its `smach_ros` and `rospy`.

    python ros1_run.py FILE...

Each file is run as a program; its `rostest.rosrun(package, name, TestCase)` runs the tests. Prints a line a test. The
reference action server that the tests expect is `ref_server.py` next to the file, where there is one.
"""

import runpy
import sys
import unittest
from pathlib import Path
from types import ModuleType

import ros1_messages

from grip_bt import smach_compat
from grip_bt.smach_compat import smach_ros
from grip_bt.smach_compat.ros1 import rospy
from grip_bt.smach_compat.smach_ros._port import Ros


def _tell(result, suite):
    wrong = {str(test): text for test, text in [*result.failures, *result.errors]}
    for test in suite:
        sys.stdout.write(f"{test._testMethodName} {'failed' if str(test) in wrong else 'passed'}\n")
    for text in wrong.values():
        sys.stderr.write(text)


def _rosrun(package, name, test_class):
    tests = list(unittest.defaultTestLoader.loadTestsFromTestCase(test_class))
    result = unittest.TestResult()
    for test in tests:
        test.run(result)
    _tell(result, tests)


def main(files):
    rostest = ModuleType("rostest")
    rostest.rosrun = _rosrun
    sys.modules.update(ros1_messages.modules(), rostest=rostest)
    rospy.spin = lambda: None  # programs that serve go on in threads
    # The network is this process: its pickles are ours.
    smach_compat.install(rospy=True, unpickle_userdata=True)
    for file in map(Path, files):
        smach_ros.use(Ros())
        server = file.with_name("ref_server.py")
        if server.exists():
            runpy.run_path(str(server), run_name="__main__")
        runpy.run_path(str(file), run_name="__main__")
        rospy.signal_shutdown("the end")


if __name__ == "__main__":
    main(sys.argv[1:])
