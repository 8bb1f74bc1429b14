"""Calls over the bus end: with the answer, or with the name of what went wrong."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from patience import PATIENCE, until
from ros_bench import ended

from grip_bt.base.errors import GripError
from grip_bt.base.failures import CanceledError, IncompatibleServerError, ServerLostError, ServerTimeOutError
from grip_bt.ros.client.bus import Bus

pytestmark = pytest.mark.ros
SET, TRIGGER = "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"


def request(data=False):
    from std_srvs.srv import SetBool

    return SetBool.Request(data=data)


def test_a_call_ends_with_the_answer_and_wakes_its_owner(bus, serve):
    serve("std_srvs/SetBool", "/set")
    operation = bus.service(SET, "/set").call(request())
    woken = threading.Event()
    operation.add_done_callback(woken.set)
    assert ended(operation).success is True
    assert woken.wait(PATIENCE)


def test_more_calls_than_a_server_remembers_are_all_answered(bus, serve):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    operations = [client.call(request()) for _ in range(200)]
    assert all(ended(operation).success for operation in operations)


def test_calls_from_many_threads_all_end(bus, serve):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    ended(client.wait_ready(PATIENCE))

    def calls(_):
        return [ended(client.call(request())).success for _ in range(40)]

    with ThreadPoolExecutor(12) as pool:
        assert all(all(answers) for answers in pool.map(calls, range(12)))
    assert not client.in_flight


def test_each_caller_of_a_name_waits_as_long_as_it_says(bus, ahead):
    first, second = bus.service(SET, "/nobody"), bus.service(SET, "/nobody")
    patient, brief = first.call(request(), timeout=5000.0, wait=3000.0), second.call(request(), wait=10.0)
    ended(bus.post(lambda: None))
    ahead.skip(20.0)
    with pytest.raises(ServerLostError, match="no server within 10.0 s"):
        ended(brief)
    assert not patient.done()
    patient.cancel()


def test_a_call_that_nobody_answers_is_watched_however_it_was_sent(bus, serve, ahead):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    for _ in range(3):
        ended(client.call(request()))
    operation = client.call(request(True), timeout=1000.0)
    until(lambda: client.in_flight, "it isn't sent")
    ended(bus.post(lambda: None))  # whatever was posted before it is done
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match="no response"):
        ended(operation)


def test_closing_ends_calls_that_other_threads_send_meanwhile(serve, domain):
    serve("std_srvs/SetBool", "/set")
    with Bus("closes", domain_id=domain) as bus, ThreadPoolExecutor(4) as pool:
        client = bus.service(SET, "/set")
        ended(client.wait_ready(PATIENCE))
        sent = threading.Event()

        def calls_until_closed(_):
            while True:
                operation = client.call(request())
                sent.set()
                try:
                    ended(operation)
                except CanceledError:
                    return True

        ends = [pool.submit(calls_until_closed, n) for n in range(4)]
        assert sent.wait(PATIENCE)
        bus.close()
        assert all(end.result(PATIENCE) for end in ends)


def test_a_server_that_is_not_there_is_lost(bus):
    with pytest.raises(ServerLostError, match=r"/nobody: no server within 0\.3 s"):
        ended(bus.service(SET, "/nobody").call(request(), wait=0.3))


def test_a_server_that_comes_late_is_waited_for(bus, serve):
    operation = bus.service(SET, "/set").call(request())
    serve("std_srvs/SetBool", "/set")
    assert ended(operation).success is True


def test_a_server_of_another_type_is_refused_at_once(bus, serve):
    serve("std_srvs/Trigger", "/set")
    with pytest.raises(IncompatibleServerError, match="/set: .*node.* serves std_srvs/srv/Trigger, not std_srvs"):
        ended(bus.service(SET, "/set").call(request()))


def test_a_refused_name_can_be_used_with_its_right_type_and_then_with_no_other(bus, serve):
    from std_srvs.srv import Trigger

    serve("std_srvs/Trigger", "/set")
    with pytest.raises(IncompatibleServerError):
        ended(bus.service(SET, "/set").call(request()))
    assert ended(bus.service(TRIGGER, "/set").call(Trigger.Request())).success
    with pytest.raises(GripError, match="is used as std_srvs/srv/Trigger already"):
        bus.service(SET, "/set")


def test_two_servers_on_one_name_are_refused(bus, serve):
    serve("std_srvs/SetBool", "/set")
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    _wait_for_servers(bus, "/set", 2)
    with pytest.raises(IncompatibleServerError, match="2 servers .*each of which would execute"):
        ended(client.call(request(), wait=5))


def test_a_best_effort_server_is_refused(bus, serve):
    serve("std_srvs/SetBool", "/set:best_effort")
    with pytest.raises(IncompatibleServerError, match="best-effort"):
        ended(bus.service(SET, "/set").call(request()))


def test_an_answer_that_does_not_come_times_out(bus, serve, ahead):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    ended(client.wait_ready(PATIENCE))
    operation = client.call(request(True), timeout=1000.0)
    until(lambda: client.in_flight, "it isn't sent")
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match=r"/set: no response after 1\d\d\d\.\d s"):
        ended(operation)


def test_a_server_that_is_killed_in_the_middle_of_a_call_is_lost(bus, serve):
    process = serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    ended(client.call(request()))
    operation = client.call(request(True), timeout=1000.0)
    ended(bus.post(lambda: None))  # whatever was posted before it is done: the request is on its way
    process.send_signal(signal.SIGKILL)
    with pytest.raises(ServerLostError, match="the server disappeared while it had the request"):
        ended(operation)


def test_a_server_that_was_restarted_is_called_again(bus, serve):
    first = serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    ended(client.call(request()))
    first.kill()
    serve("std_srvs/SetBool", "/set")
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            assert ended(client.call(request())).success
            return
        except ServerLostError:
            assert time.monotonic() < deadline


def test_a_canceled_call_ends_at_once(bus, serve):
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    ended(client.wait_ready(PATIENCE))
    operation = client.call(request(True))
    operation.cancel()
    with pytest.raises(CanceledError):
        ended(operation)


def test_closing_ends_what_is_pending_and_what_comes_later(domain):
    others = set(threading.enumerate())
    bus = Bus(domain_id=domain)
    client = bus.service(SET, "/nobody")
    pending = client.call(request(), wait=60)
    bus.close()
    for operation in (pending, client.call(request()), bus.post(lambda: 1)):
        with pytest.raises(CanceledError, match="closed"):
            ended(operation)
    bus.close()
    assert not [t for t in set(threading.enumerate()) - others if t.name.startswith("ros-")]


def test_work_that_raises_reaches_whoever_posted_it_and_the_bus_goes_on(bus):
    with pytest.raises(ZeroDivisionError):
        ended(bus.post(lambda: 1 // 0))
    assert ended(bus.post(lambda: threading.current_thread().name)).startswith("ros-")


def test_a_request_of_the_wrong_type_is_an_error_of_the_caller(bus, serve):
    serve("std_srvs/SetBool", "/set")
    with pytest.raises(TypeError):
        ended(bus.service(SET, "/set").call("no request"))


FORK = """
from multiprocessing import get_context
child = get_context("fork").Process(target=bus.close)
child.start()
child.join()
assert child.exitcode == 0
"""
START = """
import os, signal, sys
from grip_bt.ros.client.bus import Bus
bus = Bus(domain_id=int(sys.argv[1]))
from std_srvs.srv import SetBool
pending = bus.service("std_srvs/srv/SetBool", "/nobody").call(SetBool.Request(), wait=60)
print("printed", end="")
"""


@pytest.mark.parametrize(
    ("ending", "status"),
    [
        ("", 0),
        ("raise ValueError", 1),
        ("sys.exit(3)", 3),
        ("bus.close()", 0),
        ("bus.close(); Bus(domain_id=int(sys.argv[1]))", 0),
        ("os.kill(os.getpid(), signal.SIGINT)", -signal.SIGINT),
        (FORK, 0),
    ],
)
def test_a_script_that_uses_the_bus_ends_as_it_should(domain, ending, status):
    done = subprocess.run(
        [sys.executable, "-c", START + ending, str(domain)],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == status, done.stderr
    assert done.stdout.startswith("printed")
    assert "terminate called" not in done.stderr


def _wait_for_servers(bus, name, number):
    from grip_bt.ros.client.graph import endpoints_of

    until(lambda: len(ended(bus.post(lambda: endpoints_of(bus.node, name)))) == number, "the servers aren't seen")


def test_the_domain_keeps_buses_apart(bus, serve, other_domain):
    serve("std_srvs/SetBool", "/set")
    ended(bus.service(SET, "/set").wait_ready(PATIENCE))
    with Bus("other", domain_id=other_domain) as other, pytest.raises(ServerLostError):
        ended(other.service(SET, "/set").call(request(), wait=0.5))
    assert os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST"


def test_what_is_posted_is_done_in_order(bus):
    done = []
    last = [bus.post(lambda n=n: done.append(n)) for n in range(200)][-1]
    ended(last)
    assert done == list(range(200))


@pytest.mark.parametrize("name", ["bad topic", "/7th", "/a//b", "", "/a/"])
def test_a_name_that_ros_does_not_know_is_told_with_what_it_knows(bus, name):
    for client in (bus.service, bus.action, bus.reader, bus.writer):
        with pytest.raises(GripError, match="can't name a topic, a service or an action: letters, digits"):
            client("std_msgs/msg/String", name)
