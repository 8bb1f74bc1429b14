"""Goals over the bus end: with what the server says, or with the name of what went wrong; none is left behind."""

from __future__ import annotations

import contextlib
import json
import math
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter

import pytest
from patience import PATIENCE, until
from ros_bench import ended

from grip_bt.base.errors import GripError
from grip_bt.base.failures import (
    CanceledError,
    GoalRejectedError,
    IncompatibleServerError,
    ServerLostError,
    ServerTimeOutError,
)
from grip_bt.ros.client.goal import GoalEnd, Phase

pytestmark = pytest.mark.ros
WORK = "trial_interfaces/action/Work"
RACES = int(os.environ.get("GRIP_FUZZ_GOALS", "100"))


def work(how="finish", seconds=0.05):
    from trial_interfaces.action import Work

    return Work.Goal(input=how, seconds=seconds)


def counts(bus, name="/work"):
    from std_srvs.srv import Trigger

    client = bus.service("std_srvs/srv/Trigger", f"{name}/counts")
    return json.loads(ended(client.call(Trigger.Request())).message)


def comes(bus, what, number):
    until(lambda: counts(bus)[what] == number, f"never {number} {what}")
    return True


def no_active_goal(bus):
    def none() -> bool:
        with contextlib.suppress(ServerLostError):  # the one before it, killed a moment ago
            return counts(bus)["active"] == 0
        return False

    until(none, "a goal is left")
    return True


def phases(client):
    return [entry.machine.phase for entry in list(client._requests) if entry.servers]


def test_a_goal_ends_with_its_result_and_tells_of_its_progress(bus, act):
    act()
    seen, client = [], bus.action(WORK, "/work")
    times = {"timeout": 1000.0, "cancel_within": PATIENCE}
    operation = client.send(work(seconds=600.0), on_feedback=lambda f: seen.append(f.progress), **times)
    until(lambda: len(seen) > 2, "it tells of nothing")
    operation.cancel()
    assert ended(operation).status == "canceled"
    assert seen == sorted(seen)
    end = ended(client.send(work(seconds=0.05)))
    assert (end.status, end.result.returned_object) == ("succeeded", "did finish")


def test_an_aborted_goal_says_so_with_its_result(bus, act):
    act()
    end = ended(bus.action(WORK, "/work").send(work("abort")))
    assert (end.status, end.result.returned_object) == ("aborted", "too heavy")


def test_a_rejected_goal_is_named(bus, act):
    act()
    with pytest.raises(GoalRejectedError, match="/work: the server rejected the goal"):
        ended(bus.action(WORK, "/work").send(work("reject")))


@pytest.mark.parametrize("after", [0.0, 0.1])
def test_a_canceled_goal_ends_at_the_server_too(bus, act, after):
    act()
    ended(bus.action(WORK, "/work").wait_ready(PATIENCE))
    operation = bus.action(WORK, "/work").send(work(seconds=600.0), cancel_within=PATIENCE)
    time.sleep(after)
    operation.cancel()
    assert ended(operation).status == "canceled"
    assert counts(bus)["active"] == 0


def test_a_goal_whose_time_is_over_is_cancelled_at_the_server(bus, act, ahead):
    act()
    client = bus.action(WORK, "/work")
    operation = client.send(work(seconds=600.0), timeout=1000.0)
    until(lambda: phases(client) == [Phase.RUNNING], "the server doesn't take it")
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match=r"/work: no result after 1\d\d\d\.\d s"):
        ended(operation)
    assert no_active_goal(bus)
    assert counts(bus)["canceled"] == 1


def test_a_goal_taken_after_its_time_is_cancelled_when_it_is_taken(bus, act, ahead, tmp_path):
    act()
    client = bus.action(WORK, "/work")
    ended(client.send(work(seconds=0.0)))
    operation = client.send(work(f"slow_accept {tmp_path}/go", 600.0), timeout=1000.0)
    until(lambda: phases(client) == [Phase.SENT], "it isn't sent")
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match="the server did not accept the goal"):
        ended(operation)
    (tmp_path / "go").touch()
    assert comes(bus, "canceled", 1)
    assert no_active_goal(bus)


def test_a_goal_whose_acceptance_was_lost_ends_with_its_result(bus, act):
    act()
    end = ended(bus.action(WORK, "/work").send(work("unanswered", 0.1)))
    assert (end.status, end.result.returned_object) == ("succeeded", "did unanswered")


@pytest.mark.parametrize("lost", ["unanswered", "unseen"])
def test_a_goal_whose_acceptance_was_lost_can_be_canceled(bus, act, lost):
    act()
    ended(bus.action(WORK, "/work").wait_ready(PATIENCE))
    operation = bus.action(WORK, "/work").send(work(lost, 600.0), timeout=1000.0, cancel_within=PATIENCE)
    operation.cancel()
    assert ended(operation).status == "canceled"
    assert (counts(bus)["active"], counts(bus)["canceled"]) == (0, 1)


def test_a_goal_that_nobody_saw_accepted_is_cancelled_when_its_time_is_over(bus, act, ahead):
    act()
    operation = bus.action(WORK, "/work").send(work("unseen", 600.0), timeout=1000.0)
    assert comes(bus, "active", 1)
    ahead.skip(1000.0)
    with pytest.raises(ServerTimeOutError, match="the server did not accept the goal"):
        ended(operation)
    assert comes(bus, "canceled", 1)
    assert no_active_goal(bus)


@pytest.fixture
def patient_ends(monkeypatch):
    """Have a bus that is closed wait for servers as long as a slow machine needs."""
    monkeypatch.setattr("grip_bt.ros.client.connection.LETTING_GO", PATIENCE)


def test_closing_the_bus_cancels_a_goal_that_nobody_saw_accepted(domain, act, patient_ends):
    from patient_bus import PatientBus

    act()
    with PatientBus("looks", domain_id=domain) as other, PatientBus("closes", domain_id=domain) as first:
        operation = first.action(WORK, "/work").send(work("unseen", 600.0), timeout=1000.0)
        assert comes(other, "active", 1)
        first.close()
        with pytest.raises(CanceledError, match="closed"):
            ended(operation)
        assert no_active_goal(other)
        assert counts(other)["canceled"] == 1


def test_a_server_that_refuses_to_stop_ends_for_the_owner_and_says_so(bus, act, ahead):
    act()
    client = bus.action(WORK, "/work")
    operation = client.send(work("stubborn", 600.0), timeout=5000.0, cancel_within=1000.0)
    assert comes(bus, "active", 1)
    operation.cancel()
    until(
        lambda: any(entry.machine.refused for entry in list(client._requests) if entry.servers),
        "the server doesn't answer",
    )
    ahead.skip(1000.0)
    with pytest.raises(CanceledError, match="refused to stop"):
        ended(operation)


def test_a_server_that_is_not_there_is_lost(bus, trial):
    with pytest.raises(ServerLostError, match=r"/nobody: no server within 0\.3 s"):
        ended(bus.action(WORK, "/nobody").send(work(), wait=0.3))


def test_a_server_that_dies_is_noticed_long_before_the_deadline_and_its_successor_serves(bus, act):
    act()
    client = bus.action(WORK, "/work")
    with pytest.raises(ServerLostError, match="the action server disappeared while executing the goal"):
        ended(client.send(work("die", 0.0), timeout=1000.0))
    act()
    assert ended(client.send(work())).status == "succeeded"


def test_two_action_servers_on_one_name_are_refused(bus, act):
    act()
    act()
    client = bus.action(WORK, "/work")
    until(lambda: len(ended(bus.post(lambda: _servers(bus)))) == 2, "the servers aren't seen")
    with pytest.raises(IncompatibleServerError, match="2 servers .*each of which would execute a goal"):
        ended(client.send(work(), wait=5))


def _servers(bus):
    from grip_bt.ros.client.graph import endpoints_of

    return endpoints_of(bus.node, "/work/_action/send_goal")


def test_a_name_has_one_type(bus, act):
    act()
    ended(bus.action(WORK, "/work").send(work()))
    with pytest.raises(GripError, match="is used as trial_interfaces/action/Work already"):
        bus.action("std_srvs/srv/Trigger", "/work")


def test_more_goals_than_a_server_remembers_all_end(bus, act):
    act()
    client = bus.action(WORK, "/work")
    operations = [client.send(work(seconds=0.02)) for _ in range(60)]
    assert {ended(o).status for o in operations} == {"succeeded"}


def test_a_goal_that_is_not_one_fails_at_once(bus, act):
    act()
    with pytest.raises(TypeError):
        ended(bus.action(WORK, "/work").send("a text"))


def test_closing_the_bus_cancels_what_runs(domain, act, patient_ends):
    from patient_bus import PatientBus

    act()
    with PatientBus("closes", domain_id=domain) as first:
        operation = first.action(WORK, "/work").send(work(seconds=600.0), timeout=1000.0)
        with PatientBus("looks", domain_id=domain) as other:
            assert comes(other, "active", 1)
            first.close()
            with pytest.raises(CanceledError, match="closed"):
                ended(operation)
            assert no_active_goal(other)


def test_the_end_of_an_interpreter_cancels_what_runs(domain, act, trial, bus):
    act()
    script = (
        "import threading, sys; from grip_bt.ros.client import bus as module, connection\n"
        "from trial_interfaces.action import Work\n"
        f"connection.LETTING_GO, taken = {PATIENCE}, threading.Event()\n"
        "bus = module.Bus('leaves')\n"
        "client = bus.action('trial_interfaces/action/Work', '/work')\n"
        "goal = Work.Goal(input='finish', seconds=600.0)\n"
        f"client.send(goal, 1000.0, {PATIENCE}, on_feedback=lambda told: taken.set())\n"
        f"assert taken.wait({PATIENCE}); sys.exit(3)\n"
    )
    from grip_bt.ros.command import child_environment

    done = subprocess.run([sys.executable, "-c", script], env=child_environment([trial], domain), timeout=2 * PATIENCE)
    assert done.returncode == 3
    assert counts(bus)["accepted"] == 1
    assert no_active_goal(bus)


def test_random_races_leave_no_goal_and_name_every_failure(bus, act, monkeypatch):
    """Owners that cancel, time-outs, refusals, lost acceptances at random moments, and a real server that is killed."""
    monkeypatch.setattr("grip_bt.ros.client.goal.FORGET", 2.0)
    drawn = random.Random(int(os.environ.get("GRIP_FUZZ_SEED", "0")))
    server, kills, ends = act(), 0, Counter()
    client = bus.action(WORK, "/work")
    for start in range(0, RACES, 20):
        operations = [_race(client, drawn) for _ in range(min(20, RACES - start))]
        if start % 100 == 80:
            time.sleep(drawn.random() * 0.1)
            server.send_signal(signal.SIGKILL)
            server.wait()
            server, kills = act(), kills + 1
        for operation in operations:
            assert operation.wait(2 * PATIENCE), "a goal hangs"
            ends[_named(operation)] += 1
    assert no_active_goal(bus)
    until(lambda: not client._requests, "goals aren't forgotten")
    sys.stdout.write(f"{RACES} goals against a real server, killed {kills} times: {dict(ends.most_common())}\n")
    assert set(ends) <= {"succeeded", "aborted", "canceled", "rejected", "timed_out", "server_lost"}


def _race(client, drawn):
    how = drawn.choice(("finish", "finish", "abort", "reject", "unanswered", "unseen"))
    timeout = drawn.choice((20.0, 20.0, 0.02, 0.1))
    operation = client.send(work(how, drawn.choice((0.0, 0.01, 0.1))), timeout=timeout)
    if drawn.random() < 0.5:
        time.sleep(drawn.choice((0.0, 0.001, 0.01)))
        operation.cancel()
    return operation


def _named(operation):
    try:
        end = operation.result()
    except GripError as error:
        return error.code
    assert isinstance(end, GoalEnd)
    return end.status


def test_a_goal_may_take_for_ever(bus, act):
    act()
    assert ended(bus.action(WORK, "/work").send(work(), timeout=math.inf)).status == "succeeded"
