"""Runs files written for ROS 1 as they are, in this process, on the stand-in, `smach_compat` and its `smach_ros`.

    python standin_run.py FILE...

Each file is run as a program; its `rostest.rosrun(package, name, TestCase)` runs the tests. Prints a line a test. The
reference action server that the tests expect is `ref_server.py` next to the file, where there is one.
"""

import runpy
import sys
import unittest
from pathlib import Path
from types import ModuleType

import standin_messages
import standin_rospy

from grip_bt import smach_compat


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
    standin_rospy.spin = lambda: None  # programs that serve go on in threads
    rostest = ModuleType("rostest")
    rostest.rosrun = _rosrun
    sys.modules.update(standin_messages.modules(), rostest=rostest)
    # The network is this process: its pickles are ours.
    smach_compat.install(unpickle_userdata=True)
    for file in map(Path, files):
        standin_rospy.master.reset()
        server = file.with_name("ref_server.py")
        if server.exists():
            runpy.run_path(str(server), run_name="__main__")
        runpy.run_path(str(file), run_name="__main__")
        standin_rospy.master.shutdown.set()


if __name__ == "__main__":
    main(sys.argv[1:])
