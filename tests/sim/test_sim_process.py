"""The simulator's process: how it comes up, and that it always ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from patience import PATIENCE, until
from sim_bench import SPEC, Bench

from grip_bt.base.errors import SimulatorLostError, UnknownNameError
from grip_sim import connection as process_module
from grip_sim.simulation import start_simulation
from grip_sim.specs import ObjectSpec, WorldSpec

PARENT = """
import sys, threading
from grip_sim.simulation import start_simulation
from grip_sim.specs import WorldSpec

simulation = start_simulation(WorldSpec())
print(simulation.pid, flush=True)
if sys.argv[1] == "moving":
    simulation.move("wait", seconds=1e9)
threading.Event().wait()
"""


@pytest.fixture
def simulation():
    with start_simulation(SPEC) as made:
        yield made


def alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_importing_the_package_loads_no_sapien_and_no_motion_library():
    code = "import sys, grip_sim; sys.exit(any(m in sys.modules for m in ('sapien', 'pinocchio', 'coal', 'ompl')))"
    assert subprocess.run([sys.executable, "-W", "error", "-c", code], timeout=PATIENCE).returncode == 0


@pytest.mark.sim
def test_when_the_process_is_killed_motions_and_questions_fail_and_nothing_hangs(simulation):
    bench = Bench(simulation)
    motion = bench.arm.execute(bench.way(bench.arm.state().position + 0.2, 1000.0))
    os.kill(simulation.pid, signal.SIGKILL)
    assert motion.wait(PATIENCE)
    with pytest.raises(SimulatorLostError, match=f"process {simulation.pid} is gone .*exit status -9"):
        motion.result()
    for call in (bench.arm.state, bench.hand.contacts, bench.referee.truth, bench.arm.stop, simulation.settle):
        with pytest.raises(SimulatorLostError):
            call()
    for operation in (bench.hand.move(bench.closed, 1.0), simulation.camera("overhead").capture()):
        assert operation.wait(PATIENCE)
        with pytest.raises(SimulatorLostError):
            operation.result()


@pytest.mark.sim
@pytest.mark.parametrize("doing", ["nothing", "moving"])
def test_closing_ends_the_process_whatever_it_does(doing):
    simulation = start_simulation(SPEC)
    bench = Bench(simulation)
    motion = bench.hand.move(bench.closed, 1000.0) if doing == "moving" else None
    simulation.close()
    assert not alive(simulation.pid)
    if motion is not None:
        assert motion.done()
        with pytest.raises(SimulatorLostError, match="closed"):
            motion.result()
    simulation.close()


@pytest.mark.sim
def test_a_stopped_process_is_killed_by_closing():
    simulation = start_simulation(SPEC)
    os.kill(simulation.pid, signal.SIGSTOP)
    simulation.close()
    assert not alive(simulation.pid)


@pytest.mark.sim
@pytest.mark.parametrize("doing", ["nothing", "moving"])
def test_no_process_is_left_when_its_parent_is_killed(doing):
    parent = subprocess.Popen([sys.executable, "-c", PARENT, doing], stdout=subprocess.PIPE, text=True)
    with parent:
        pid = int(parent.stdout.readline())
        try:
            assert alive(pid)
            parent.kill()
            parent.wait()
            until(lambda: not alive(pid), "it is left")
        finally:
            if alive(pid):
                os.kill(pid, signal.SIGKILL)


@pytest.mark.sim
def test_callbacks_of_real_motions_may_ask_and_wait(simulation):
    bench, seen = Bench(simulation), []
    operation = bench.hand.move(bench.half_closed, 0.3)
    then = operation.then(lambda end: bench.hand.move(bench.opened, 0.3))
    operation.add_done_callback(lambda: seen.append((bench.hand.contacts(), bench.hand.state().position)))
    bench.wait(then)
    assert seen[0][0] == {}
    assert len(seen[0][1]) == 16


@pytest.mark.sim
def test_frames_come_with_the_cameras_geometry(simulation):
    camera = simulation.camera("overhead")
    capture = camera.capture()
    assert capture.wait(PATIENCE)
    frame = capture.result()
    assert frame.image.pixels.shape == (240, 320, 3)
    assert frame.depth.info == camera.info()
    assert np.median(frame.depth.depth) == pytest.approx(1.30, abs=1e-3)


@pytest.mark.sim
def test_a_world_that_can_not_be_made_says_why():
    twice = tuple(ObjectSpec("same", "box", 0.03, 0.1, (0.5, y, 0.05)) for y in (0.0, 0.2))
    with pytest.raises(SimulatorLostError, match="more than one is 'same'"):
        start_simulation(WorldSpec(objects=twice))


def test_an_unknown_robot_is_found_before_a_process_runs(monkeypatch):
    monkeypatch.setattr(process_module.subprocess, "Popen", None)
    with pytest.raises(UnknownNameError, match="panda_allegro"):
        start_simulation(WorldSpec(robot="panda_alegro"))


@pytest.mark.parametrize("pace", [0.0, -1.0, float("nan"), float("inf")])
def test_a_pace_is_a_positive_number(monkeypatch, pace):
    monkeypatch.setattr(process_module.subprocess, "Popen", None)
    with pytest.raises(ValueError, match="pace must be a positive number"):
        start_simulation(WorldSpec(), pace)


@pytest.mark.sim
def test_what_the_process_prints_stays_out_of_our_standard_output(capfd):
    with start_simulation(WorldSpec()):
        pass
    assert capfd.readouterr().out == ""
