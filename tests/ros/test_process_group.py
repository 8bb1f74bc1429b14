"""Processes that belong together: their order, their ends, and that nothing of them is left."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from patience import PATIENCE, Ahead, until
from ros_bench import ended

from grip_bt.ros.client.types import load_type
from grip_bt.ros.command import child_environment
from grip_bt.ros.process_group import GraphWatch, Member, ProcessGroup, StartError
from grip_bt.task.catalog.start import ProcessConfig, Ready

MARK = "GRIP_TEST_GROUP"


@pytest.fixture
def mark(tmp_path) -> str:
    return f"{MARK}={tmp_path}"


@pytest.fixture
def ahead(monkeypatch) -> Ahead:
    """Return the time of groups; a test may skip some of it."""
    clock = Ahead()
    monkeypatch.setattr("grip_bt.ros.process_group.time", clock)
    return clock


def member(tmp_path, name: str, code: str, **more) -> Member:
    env = child_environment() | {MARK: str(tmp_path)}
    return Member(name, [sys.executable, "-u", "-c", code], tmp_path, env, ProcessConfig(command=["it"], **more))


def marked(mark: str) -> list[int]:
    """Return the processes that carry the mark in their environment."""
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                if mark.encode() in (folder / "environ").read_bytes().split(b"\0"):
                    found.append(int(folder.name))
            except OSError:
                continue
    return found


def none_left(mark: str) -> bool:
    """Wait until no process with the mark is left; each would run for much longer by itself."""
    until(lambda: not marked(mark), f"left: {marked(mark)}")
    return True


SLEEP = "import time; time.sleep(600)"
STUBBORN = """
import signal, subprocess, sys, time
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN)
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], start_new_session=True)
print("up"); time.sleep(600)
"""


def test_each_starts_when_those_before_it_are_ready(tmp_path):
    first = member(
        tmp_path,
        "first",
        "import time; time.sleep(0.4); print('serving now'); time.sleep(600)",
        ready=Ready(log="^serving", within=PATIENCE),
    )
    second = member(tmp_path, "second", SLEEP)
    told = []
    with ProcessGroup([first, second], tmp_path / "logs", on_change=lambda *event: told.append(event[:2])) as group:
        group.start()
        assert told == [("first", "starting"), ("first", "ready"), ("second", "starting"), ("second", "ready")]
        assert (tmp_path / "logs" / "first.log").read_text() == "serving now\n"


def test_one_that_does_not_become_ready_ends_all_and_shows_its_log(tmp_path, mark, ahead):
    slow = member(tmp_path, "slow", f"print('loading'); {SLEEP}", ready=Ready(log="done", within=4 * PATIENCE))
    group = ProcessGroup([member(tmp_path, "other", SLEEP), slow], tmp_path / "logs")
    log = tmp_path / "logs" / "slow.log"

    def wait_then_skip() -> None:
        until(lambda: log.exists() and "loading" in log.read_text())
        ahead.skip(4 * PATIENCE)

    threading.Thread(target=wait_then_skip).start()
    with pytest.raises(StartError, match=r"slow: a line like 'done' wasn't there within 1600 s(.|\n)*loading"):
        group.start()
    assert none_left(mark)


def test_one_that_ends_before_it_is_ready_is_told_at_once(tmp_path):
    broken = member(tmp_path, "broken", "raise SystemExit('no robot at 10.0.0.2')", ready=Ready(log="x", within=600))
    with pytest.raises(StartError, match=r"'broken' ended with status 1(.|\n)*no robot at 10.0.0.2"):
        ProcessGroup([broken], tmp_path / "logs").start()


def test_a_required_one_that_fails_ends_all(tmp_path, mark):
    failing = member(tmp_path, "failing", "import time; time.sleep(0.3); raise SystemExit(7)")
    group = ProcessGroup([member(tmp_path, "other", SLEEP), failing], tmp_path / "logs")
    group.start()
    assert "'failing' ended with status 7" in group.run()
    assert group.states() == {"other": "stopped", "failing": "failed"}
    assert none_left(mark)


def test_one_that_may_fail_leaves_the_others_alone(tmp_path):
    failing = member(tmp_path, "failing", "raise SystemExit(7)", required=False)
    other = member(tmp_path, "other", "import time; time.sleep(0.6)")
    group = ProcessGroup([failing, other], tmp_path / "logs")
    group.start()
    assert "status 7" in group.run()
    assert group.states() == {"other": "ended", "failing": "failed"}


def test_one_is_started_again_as_often_as_it_may_each_time_with_a_log(tmp_path):
    code = "import sys; print('again'); sys.exit(3)"
    restarted = member(tmp_path, "it", code, restart="on_failure", restarts=2, restart_delay=0.05)
    told = []
    group = ProcessGroup([restarted], tmp_path / "logs", on_change=lambda *event: told.append(event[1]))
    group.start()
    assert "after 3 starts" in group.run()
    assert told.count("restarting") == 2
    assert sorted(f.name for f in (tmp_path / "logs").iterdir()) == ["it.2.log", "it.3.log", "it.log"]


def test_a_good_end_is_no_failure_and_not_repeated_on_failure(tmp_path):
    group = ProcessGroup([member(tmp_path, "it", "print(1)", restart="on_failure")], tmp_path / "logs")
    group.start()
    assert group.run() == ""
    assert group.states() == {"it": "ended"}


@pytest.mark.slow
def test_all_end_at_once_whatever_they_do_against_it(tmp_path, mark):
    members = [member(tmp_path, f"m{i}", STUBBORN, ready=Ready(log="up", within=PATIENCE)) for i in range(3)]
    group = ProcessGroup(members, tmp_path / "logs")
    group.start()
    assert len(marked(mark)) >= 6
    group.close()
    assert none_left(mark)  # after three seconds where the machine is idle


@pytest.mark.slow
def test_nothing_is_left_after_grip_launch_is_killed(tmp_path, mark):
    code = STUBBORN.replace("\n", "\\n").replace('"', '\\"')
    (tmp_path / "grip.yaml").write_text(
        "grip: 1\nprocesses:\n"
        f"  one: {{command: ['{{python}}', -u, -c, \"{code}\"], ready: {{log: up, within: 400}}}}\n"
        f"  two: {{command: ['{{python}}', -u, -c, \"{SLEEP}\"]}}\n"
    )
    env = dict(os.environ, **{MARK: str(tmp_path)})
    command = [sys.executable, "-m", "grip_bt.cli", "launch", "--project", str(tmp_path)]
    launch = subprocess.Popen(command, env=env, stderr=subprocess.PIPE, text=True)
    lines = []
    for line in launch.stderr:
        lines.append(line.split())
        if lines[-1][:2] == ["two", "ready"]:
            break
    launch.send_signal(signal.SIGKILL)
    launch.wait()
    launch.stderr.close()
    assert none_left(mark)


@pytest.mark.ros
def test_a_served_name_tells_that_it_is_ready_and_its_loss_that_it_is_silent(tmp_path, domain, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setattr("grip_bt.ros.process_group.SILENCE", 0.5)
    seen = tmp_path / "seen"
    code = f"""
import pathlib, time, rclpy
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("server")
service = node.create_service(Trigger, "/ready_at_last", lambda q, a: a)
while not pathlib.Path({str(seen)!r}).exists():
    time.sleep(0.02)
node.destroy_service(service)
time.sleep(600)
"""
    told: list[tuple[str, str]] = []
    silent = threading.Event()

    def tell(name, state, detail):
        told.append((state, detail))
        if state == "silent":
            silent.set()

    server = member(tmp_path, "server", code, ready=Ready(service="/ready_at_last", within=PATIENCE))
    with ProcessGroup([server], tmp_path / "logs", domain_id=domain, on_change=tell) as group:
        group.start()
        assert [state for state, _ in told] == ["starting", "ready"]
        watcher = threading.Thread(target=group.run)
        watcher.start()
        seen.touch()
        assert silent.wait(PATIENCE), told
        group.ask_to_stop()
        watcher.join(PATIENCE)
    assert "/ready_at_last disappeared" in told[2][1]


@pytest.mark.ros
def test_a_sign_that_does_not_come_is_told_with_what_is_there(tmp_path, domain):
    mute = member(tmp_path, "mute", SLEEP, ready=Ready(topic="/lamp", within=0.3))
    with pytest.raises(StartError, match=rf"the topic /lamp wasn't there within 0\.3 s; .* in ROS_DOMAIN_ID {domain}"):
        ProcessGroup([mute], tmp_path / "logs", domain_id=domain).start()


@pytest.mark.ros
def test_what_is_there_is_the_likeliest_name(bus, domain):
    ended(bus.writer("std_msgs/msg/Bool", "/lamps").publish(load_type("std_msgs/msg/Bool")()))
    service = ended(bus.post(lambda: bus.node.create_service(load_type("std_srvs/srv/Trigger"), "/swich", print)))
    watch = GraphWatch(domain)
    until(lambda: watch.sees(Ready(topic="/lamps")) and watch.sees(Ready(service="/swich")), "they aren't seen")
    try:
        assert watch.instead(Ready(log="done")) == ""
        lamp = watch.instead(Ready(topic="/lamp"))
        assert lamp == f"; published in ROS_DOMAIN_ID {domain}: /lamps (std_msgs/msg/Bool)"
        told = (
            f"; /swich itself is std_srvs/srv/Trigger; published in ROS_DOMAIN_ID {domain}: /lamps (std_msgs/msg/Bool)"
        )
        assert watch.instead(Ready(topic="/swich")) == told
        assert "; /lamps itself is std_msgs/msg/Bool; served in" in watch.instead(Ready(service="/lamps"))
        switch = watch.instead(Ready(service="/switch"))
        assert switch.startswith(f"; served in ROS_DOMAIN_ID {domain}: /swich (std_srvs/srv/Trigger)")
    finally:
        watch.close()
        bus.post(lambda: bus.node.destroy_service(service)).wait(PATIENCE)


def test_what_processes_print_is_copied_line_by_line_with_their_names(tmp_path):
    output = io.StringIO()
    one = member(tmp_path, "one", "print('a'); print('b', end='')", required=False)
    group = ProcessGroup([one], tmp_path / "logs", output=output)
    group.start()
    group.run()
    assert output.getvalue() == "[one] a\n[one] b\n"
