"""Programs of ROS 1 run as they are on `smach_compat` with `rospy`; upstream's own tests too, where they are.

GRIP_SMACH_UPSTREAM=/path/to/executive_smach (branch noetic-devel) gives the checkout.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PROGRAM = HERE / "data" / "ros1_program.py"
UPSTREAM = os.environ.get("GRIP_SMACH_UPSTREAM")
SUITES = ("state_machine", "sequence", "concurrence", "monitor", "services", "introspection_test", "smach_actionlib")


def results(file):
    """Return test -> passed or failed, and what was said."""
    done = subprocess.run(
        [sys.executable, str(HERE / "ros1_run.py"), str(file)], capture_output=True, text=True, timeout=600
    )
    return dict(re.findall(r"^(test_\w+) (passed|failed)$", done.stdout, re.MULTILINE)), done.stderr


def test_a_program_of_ros_1_with_actions_services_topics_and_introspection_runs_unchanged():
    passed, said = results(PROGRAM)
    written = re.findall(r"def (test_\w+)", PROGRAM.read_text())
    assert passed == dict.fromkeys(written, "passed"), said
    assert len(written) == 12


@pytest.mark.slow
@pytest.mark.skipif(
    not UPSTREAM, reason="GRIP_SMACH_UPSTREAM doesn't name a checkout of executive_smach (noetic-devel)"
)
@pytest.mark.parametrize("name", SUITES)
def test_upstreams_own_tests_pass_unmodified(name):
    file = Path(UPSTREAM) / "smach_ros" / "test" / f"{name}.py"
    passed, said = results(file)
    assert passed, said
    assert passed == dict.fromkeys(re.findall(r"def (test_\w+)\(", file.read_text()), "passed"), said
