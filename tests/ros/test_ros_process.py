"""Processes that we start end with us, whatever they do against it."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import pytest
from patience import PATIENCE, until
from ros_bench import gone, kill, session_of

from grip_bt.ros.command import child_environment
from grip_bt.ros.process import Process
from grip_bt.task.catalog.start import Start

STUBBORN = """
import os, signal, subprocess, sys, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], start_new_session=True)
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
open(sys.argv[1], "w").write("up")
time.sleep(600)
"""


def start(tmp_path: Path, code: str, *arguments: str) -> Process:
    command = [sys.executable, "-u", "-c", code, *arguments]
    return Process("it", command, tmp_path, child_environment(), tmp_path / "logs" / "it.log")


def test_its_end_is_told_with_status_and_last_words(tmp_path):
    process = start(tmp_path, "print('one'); print('two'); raise SystemExit(5)")
    told = threading.Event()
    process.when_ended(told.set)
    assert told.wait(PATIENCE)
    assert (process.returncode, process.alive) == (5, False)
    assert process.log_tail(1) == "two"
    assert "ended with status 5" in process.describe_end()


def test_it_is_started_again_as_often_as_it_may(tmp_path):
    again = Start(command=["x"], restart="on_failure", restarts=2, restart_delay=0)
    command = [sys.executable, "-u", "-c", "import os; print(os.getpid()); raise SystemExit(5)"]
    process = Process("it", command, tmp_path, child_environment(), tmp_path / "it.log", again)
    told, broke = threading.Event(), []
    process.when_broken(lambda: broke.append(process.describe_end()))
    process.when_ended(told.set)
    assert told.wait(PATIENCE)
    assert "with status 5; start 3 follows" in broke[-1]
    assert "with status 5 after 3 starts" in process.describe_end()
    assert len({*process.log_tail().splitlines()}) == 3


def test_what_waits_to_be_started_again_stops_when_it_is_asked_to(tmp_path):
    again = Start(command=["x"], restart="always", restart_delay=1000)
    process = Process("it", [sys.executable, "-c", ""], tmp_path, child_environment(), tmp_path / "it.log", again)
    until(lambda: process.returncode == 0)
    assert process.alive
    process.stop()
    assert not process.alive


def test_a_process_killed_by_a_signal_has_the_status_of_a_shell(tmp_path):
    process = start(tmp_path, "import os; os.kill(os.getpid(), 9)")
    until(lambda: not process.alive)
    assert process.returncode == 128 + 9


def test_a_polite_process_ends_politely(tmp_path):
    code = """
import signal, sys, time
try:
    print("up"); time.sleep(600)
except KeyboardInterrupt:
    print("bye"); sys.exit(0)
"""
    process = start(tmp_path, code)
    until(lambda: "up" in process.log_tail())
    process.stop()
    assert (process.returncode, process.log_tail(1)) == (0, "bye")
    process.stop()


@pytest.mark.slow
def test_a_stubborn_process_and_its_strayed_children_end_with_it(tmp_path):
    process = start(tmp_path, STUBBORN, str(tmp_path / "up"))
    until((tmp_path / "up").exists)
    below = _descendants(process.pid)
    assert len(below) == 3
    process.stop()
    assert not [pid for pid in below if Path(f"/proc/{pid}").exists()]


def test_what_a_process_leaves_behind_ends_with_it(tmp_path):
    code = "import subprocess, sys; subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'])"
    process = start(tmp_path, code)
    until(lambda: not process.alive)
    assert process.returncode == 0
    assert gone(process.pid)


@pytest.mark.slow
def test_everything_ends_when_we_are_killed(tmp_path):
    code = """
import sys
from pathlib import Path
from grip_bt.ros.command import child_environment
from grip_bt.ros.process import Process
here = Path(sys.argv[1])
command = [sys.executable, "-c", sys.argv[2], str(here / "up")]
process = Process("it", command, here, child_environment(), here / "it.log")
print(process.pid, flush=True)
sys.stdin.read()
"""
    owner = subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path), STUBBORN],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    reaper = int(owner.stdout.readline())
    until((tmp_path / "up").exists)
    below = _descendants(reaper)
    kill(owner.pid)
    owner.communicate()
    assert gone(reaper)
    until(lambda: not [pid for pid in below if Path(f"/proc/{pid}").exists()])


def test_the_command_dies_with_its_reaper(tmp_path):
    process = start(tmp_path, "print('up'); import time; time.sleep(600)")
    until(lambda: "up" in process.log_tail())
    kill(process.pid)
    assert gone(process.pid)
    process.stop()


def test_a_command_that_is_not_there_is_told_in_its_log(tmp_path):
    process = Process("it", ["no_such_program"], tmp_path, child_environment(), tmp_path / "it.log")
    until(lambda: not process.alive)
    assert process.returncode == 127
    assert "no_such_program: No such file" in process.log_tail()


def _descendants(pid: int) -> list[int]:
    found, todo = [], [pid]
    while todo:
        children = Path(f"/proc/{todo.pop()}/task").glob("*/children")
        new = [int(child) for file in children for child in file.read_text().split()]
        found += new
        todo += new
    assert session_of(pid)
    return found
