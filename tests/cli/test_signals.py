"""A terminal that has gone ends a command in order, and nothing that is printed to it raises."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys

import pytest

PROGRAM = """
import os, signal, sys, threading
if {ignored}:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
from grip_bt.cli.signals import on_stop
over = threading.Event()
on_stop(over.set)
os.write({told}, b"ready")
if not over.wait({patience}):
    os._exit(7)
print("a last word")
print("another", file=sys.stderr)
sys.stdout.flush()
os.write({told}, b"ended")
"""


def started(ignored: bool = False, patience: float = 400.0) -> tuple[subprocess.Popen[bytes], int, int]:
    """Return a process whose terminal is ours, the other end of the terminal, and what it tells."""
    ours, theirs = pty.openpty()
    reads, writes = os.pipe()
    text = PROGRAM.format(told=writes, ignored=ignored, patience=patience)
    process = subprocess.Popen(
        [sys.executable, "-c", text],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        pass_fds=[writes],
        start_new_session=True,
    )
    os.close(theirs)
    os.close(writes)
    assert os.read(reads, 5) == b"ready"
    return process, ours, reads


def test_a_terminal_that_has_gone_is_a_stop() -> None:
    process, terminal, reads = started()
    os.close(terminal)
    process.send_signal(signal.SIGHUP)
    assert os.read(reads, 5) == b"ended"
    os.close(reads)
    assert process.wait(400) == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_each_signal_is_a_stop(number: signal.Signals) -> None:
    process, terminal, reads = started()
    process.send_signal(number)
    assert os.read(reads, 5) == b"ended"
    os.close(reads)
    os.close(terminal)
    assert process.wait(400) == 0


def test_with_nohup_a_terminal_may_go() -> None:
    process, terminal, reads = started(ignored=True, patience=0.5)
    process.send_signal(signal.SIGHUP)
    assert process.wait(400) == 7
    os.close(reads)
    os.close(terminal)
