"""Starting and leaving ROS: every way out of an interpreter, children, name spaces, domains, and simulated time."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import ExitStack
from xml.etree import ElementTree

import pytest
from patience import PATIENCE, until
from ros_bench import ended

from grip_bt.base.failures import ServerLostError
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.command import child_environment
from grip_bt.ros.environment import DDS_PROFILE

pytestmark = pytest.mark.ros
OPEN = "import time, sys, os\nfrom grip_bt.ros.client.bus import Bus\nbus = Bus('leaves')\n"
PENDING = "operation = bus.service('std_srvs/srv/SetBool', '/nobody').wait_ready(600)\n"


def leave(code, domain, **more):
    return subprocess.run(
        [sys.executable, "-c", OPEN + PENDING + code],
        env=child_environment((), domain),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
        **more,
    )


@pytest.mark.parametrize(
    ("code", "status"),
    [
        ("", 0),
        ("sys.exit(3)", 3),
        ("raise RuntimeError('a bug')", 1),
        ("bus.close(); bus.close()", 0),
        ("bus.close(); Bus('again'); Bus('and_again')", 0),
        ("raise KeyboardInterrupt", 130),
    ],
)
def test_an_interpreter_ends_as_it_wanted_to(domain, code, status):
    """None aborts, hangs, or loses its status; a call is under way in each."""
    done = leave(code, domain)
    assert (done.returncode % 256 if done.returncode >= 0 else 128 - done.returncode) == status, done.stderr
    assert "terminate called" not in done.stderr


def test_ctrl_c_ends_an_interpreter_that_waits(domain):
    process = subprocess.Popen(
        [sys.executable, "-c", OPEN + PENDING + "print('up', flush=True)\noperation.wait(600)"],
        env=child_environment((), domain),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "up\n"
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=PATIENCE)
    assert process.returncode in (-signal.SIGINT, 130)
    assert "KeyboardInterrupt" in told


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_a_child_process_ends_and_leaves_the_parents_bus_alone(domain, method, tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(
        "import multiprocessing, sys, warnings\nwarnings.simplefilter('ignore')\n"
        "def work(queue):\n    queue.put(6 * 7)\n"
        "if __name__ == '__main__':\n"
        "    from grip_bt.ros.client.bus import Bus\n"
        "    with Bus('parent') as bus:\n"
        f"        kind = multiprocessing.get_context({method!r})\n"
        "        queue = kind.Queue(); child = kind.Process(target=work, args=(queue,)); child.start()\n"
        "        assert queue.get(timeout=100) == 42; child.join(100); assert child.exitcode == 0, child.exitcode\n"
        "        posted = bus.post(lambda: 'alive'); assert posted.wait(100) and posted.result() == 'alive'\n"
        "    sys.exit(5)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)], env=child_environment((), domain), timeout=2 * PATIENCE, check=False
    )
    assert done.returncode == 5


def test_a_domain_hears_only_itself(domain, other_domain, serve):
    serve("std_srvs/SetBool", "/set")
    with Bus("same", domain_id=domain) as same, Bus("other", domain_id=other_domain) as other:
        ended(same.service("std_srvs/srv/SetBool", "/set").wait_ready(PATIENCE))
        with pytest.raises(ServerLostError):
            ended(other.service("std_srvs/srv/SetBool", "/set").wait_ready(0.5))


def test_names_below_a_name_space_are_found_and_others_are_not(bus, serve):
    serve("std_srvs/SetBool", "/left/arm/set")
    ended(bus.service("std_srvs/srv/SetBool", "/left/arm/set").wait_ready(PATIENCE))
    with pytest.raises(ServerLostError, match="/right/arm/set"):
        ended(bus.service("std_srvs/srv/SetBool", "/right/arm/set").wait_ready(0.3))


def test_simulated_time_is_the_clock_topics(bus):
    from grip_bt.ros.interface import RosClock

    with RosClock(bus) as clock:
        assert clock.now() == 0.0
        assert not clock.wait_started(0.1)
        for second in (5.0, 6.5, 6.0, 7.0):
            clock_message = ended(bus.post(lambda s=second: _stamp(s)))
            ended(
                bus.writer("rosgraph_msgs/msg/Clock", "/clock").publish(clock_message, subscribers=1, timeout=PATIENCE)
            )
        until(lambda: clock.now() >= 7.0, "the time isn't heard")
        assert clock.now() == 7.0
        assert clock.wait_started(0.1)


def test_a_run_that_waits_for_simulated_time_in_vain_is_told_what_is_published(bus, monkeypatch):
    from grip_bt.app.wiring import ros as ros_parts

    monkeypatch.setattr(ros_parts, "TIME_STARTS", 0.2)
    ended(bus.writer("rosgraph_msgs/msg/Clock", "/sim/clock").publish(_stamp(1.0), subscribers=0))
    said = r"/clock: no simulated time within 0\.2 s: it has no publisher; published in ROS_DOMAIN_ID \d+: "
    with (
        ExitStack() as stack,
        pytest.raises(ServerLostError, match=said + r"/sim/clock \(rosgraph_msgs/msg/Clock\)\. Fix: start the simul"),
    ):
        ros_parts.simulated_clock(bus, stack)


def test_simulated_time_never_goes_back_and_wakes_who_waits(bus):
    from grip_bt.ros.client.topic import Received
    from grip_bt.ros.interface import RosClock

    clock = RosClock(bus)
    woken = []
    clock.on_advance(lambda: woken.append(clock.now()))
    for second in (2.0, 1.0, 3.0):
        clock._received(Received(_stamp(second), 0.0))
    assert woken == [2.0, 3.0]


def _stamp(seconds):
    from builtin_interfaces.msg import Time
    from rosgraph_msgs.msg import Clock

    return Clock(clock=Time(sec=int(seconds), nanosec=int(seconds % 1 * 1e9)))


def test_the_profile_reaches_children(domain):
    assert (
        os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] == child_environment((), domain)["FASTRTPS_DEFAULT_PROFILES_FILE"]
    )


def test_a_dead_server_is_noticed_after_its_lease_of_less_than_three_seconds():
    """DDS's own lease is 20 s. What a goal or a call makes of a server that is gone is tested with those."""
    (lease,) = ElementTree.parse(DDS_PROFILE).findall(".//{*}leaseDuration")
    seconds, nanoseconds = (float(lease.find(f"{{*}}{part}").text) for part in ("sec", "nanosec"))
    assert seconds + nanoseconds * 1e-9 < 3.0
    assert child_environment()["FASTRTPS_DEFAULT_PROFILES_FILE"] == str(DDS_PROFILE)
