"""A world that stands still in the middle of a motion, and one that is told to hold by whoever watches."""

from __future__ import annotations

import os
import socket

import numpy as np
import pytest
from sim_bench import SPEC, Bench

from grip_bt.errors import CanceledError, GripError
from grip_bt.ports import Pausable
from grip_sim import start_simulation

pytestmark = pytest.mark.sim
TURN = np.array([0.5, 0, 0, 0, 0, 0, 0.5])


def begun(bench: Bench):
    """Begin a motion of 3 s and return it when it is well under way."""
    start = bench.arm.state().position
    goal = start + TURN
    operation = bench.arm.execute(bench.way(goal, 3.0))
    while np.abs(bench.arm.state().position - start).max() < 0.05:
        pass
    return operation, goal


def test_a_paused_world_stands_still_with_its_clock_and_ends_the_motion_afterwards(bench):
    assert isinstance(bench.simulation, Pausable)
    operation, goal = begun(bench)
    bench.simulation.pause()
    bench.simulation.pause()
    clock = bench.simulation.clock
    before, time = bench.arm.state(), clock.now()
    for _ in range(50):
        assert (bench.arm.state().position == before.position).all()
    assert (clock.now(), operation.done()) == (time, False)
    bench.simulation.resume()
    assert bench.wait(operation).position == pytest.approx(goal, abs=0.02)
    assert clock.now() > time


def test_a_motion_is_stopped_in_a_paused_world_too(bench):
    operation, _ = begun(bench)
    bench.simulation.pause()
    operation.cancel()
    with pytest.raises(CanceledError):
        bench.wait(operation)
    bench.simulation.resume()


def test_the_clock_stands_in_a_pause_in_which_nothing_moves_and_goes_on_from_there(bench):
    clock = bench.simulation.clock
    bench.simulation.pause()
    time = clock.now()
    bench.arm.state()
    assert clock.now() == time
    bench.simulation.resume()
    while clock.now() == time:
        pass


def test_a_watcher_holds_the_robot_for_good_over_a_channel_of_its_own():
    ours, theirs = socket.socketpair()
    with ours, theirs, start_simulation(SPEC, hold=theirs.fileno()) as simulation:
        bench = Bench(simulation)
        operation, _ = begun(bench)
        ours.settimeout(20)
        ours.sendall(b"hold")
        assert ours.recv(4) == b"held"
        with pytest.raises(CanceledError):
            bench.wait(operation)
        with pytest.raises(GripError, match="told to hold by whoever watches over this run"):
            bench.wait(bench.arm.execute(bench.way(bench.arm.state().position)))


def test_a_watcher_that_goes_away_holds_nothing():
    ours, theirs = socket.socketpair()
    with theirs, start_simulation(SPEC, hold=theirs.fileno()) as simulation:
        ours.close()
        bench = Bench(simulation)
        operation, goal = begun(bench)
        assert bench.wait(operation).position == pytest.approx(goal, abs=0.02)
        assert os.path.exists(f"/proc/{simulation.pid}")
