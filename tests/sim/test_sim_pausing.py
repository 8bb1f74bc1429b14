"""A world that stands still in the middle of a motion, and one that is told to hold by whoever watches."""

from __future__ import annotations

import os
import socket

import numpy as np
import pytest
from patience import PATIENCE
from sim_bench import SPEC, Bench

from grip_bt.base.errors import GripError
from grip_bt.base.failures import CanceledError
from grip_bt.base.ports import Pausable
from grip_sim.motions import STILL
from grip_sim.simulation import start_simulation

pytestmark = pytest.mark.sim
TURN = np.array([0.5, 0, 0, 0, 0, 0, 0.5])


def begun(bench: Bench, duration: float = 3.0, moved: float = 0.05):
    """Begin a motion that takes a while [s] and return it when a joint has `moved` [rad]."""
    start = bench.arm.state().position
    goal = start + TURN
    operation = bench.arm.execute(bench.way(goal, duration))
    while np.abs(bench.arm.state().position - start).max() < moved:
        pass
    return operation, goal


def begun_and_paused(bench: Bench):
    """Begin a motion and pause the world in its middle; where we are too late for that, a slower one."""
    home = bench.arm.state().position
    for duration in (3.0, 20.0, 150.0):
        operation, goal = begun(bench, duration)
        bench.simulation.pause()
        if not operation.done():
            return operation, goal
        bench.simulation.resume()
        bench.go(home)
    raise AssertionError("a pause takes longer than any motion")


def test_a_paused_world_stands_still_with_its_clock_and_ends_the_motion_afterwards(bench):
    assert isinstance(bench.simulation, Pausable)
    operation, goal = begun_and_paused(bench)
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
    operation, _ = begun_and_paused(bench)
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
        operation, _ = begun(bench, 300.0, 1e-3)
        ours.settimeout(PATIENCE)
        ours.sendall(b"hold")
        assert ours.recv(4) == b"held"
        with pytest.raises(CanceledError):
            bench.wait(operation)
        with pytest.raises(GripError, match="stopped by the supervisor of this run"):
            bench.wait(bench.arm.execute(bench.way(bench.arm.state().position)))


@pytest.mark.parametrize("given_up", [False, True])
def test_a_watcher_is_told_that_the_robot_holds_when_it_was_measured_to_rest(given_up):
    ours, theirs = socket.socketpair()
    with ours, theirs, start_simulation(SPEC, hold=theirs.fileno()) as simulation:
        bench = Bench(simulation)
        operation, goal = begun(bench, 1.5, 0.2)
        if given_up:  # nothing is under way then, and the joints move
            assert bench.arm.execute(bench.way(goal, start=goal + 1.0)).wait(PATIENCE)
        ours.settimeout(PATIENCE)
        ours.sendall(b"hold")
        assert ours.recv(1024) == b"held"
        assert np.abs(bench.arm.state().velocity).max() < STILL
        assert operation.wait(PATIENCE)


def test_a_watcher_of_a_world_that_was_paused_in_a_motion_is_told_that_it_does_not_rest():
    ours, theirs = socket.socketpair()
    with ours, theirs, start_simulation(SPEC, hold=theirs.fileno()) as simulation:
        bench = Bench(simulation)
        begun(bench, 1.5, 0.2)
        simulation.pause()
        ours.settimeout(PATIENCE)
        ours.sendall(b"hold")
        assert "rad/s, in a world that is paused" in ours.recv(1024).decode()


def test_a_watcher_that_goes_away_holds_nothing():
    ours, theirs = socket.socketpair()
    with theirs, start_simulation(SPEC, hold=theirs.fileno()) as simulation:
        ours.close()
        bench = Bench(simulation)
        operation, goal = begun(bench)
        assert bench.wait(operation).position == pytest.approx(goal, abs=0.02)
        assert os.path.exists(f"/proc/{simulation.pid}")
