"""A run injects faults: when its nodes begin, and into processes of components; told in its journal."""

from __future__ import annotations

import io
import os
import signal
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest
from patience import until

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import injected
from grip_bt.app.wiring.parts import Resources
from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.runtime import JournalReader
from grip_bt.runtime.control import Control
from grip_sim.faults import Fault, read_faults

TASK = """
grip: 1
name: t
root:
  kind: sequence
  children:
    first: {node: flow/succeed}
    again: {kind: repeat, times: 2, child: {lift: {node: flow/succeed}}}
"""


class World:
    """Stands for a simulation: it takes down which nodes it is told of, and each makes its fault happen."""

    def __init__(self, **faults):
        self.spec, self.entries, self.injected, self.on_fault = SimpleNamespace(faults=faults), [], {}, None

    def inject(self, name, fault):
        self.injected[name] = fault
        self.on_fault(name, fault.fault, False)

    def entered(self, node):
        self.entries.append(node)
        self.on_fault("slip", "drop of mug", False)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "t.yaml"
    file.write_text(TASK)
    return file


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_the_world_is_told_of_the_nodes_that_faults_wait_for_and_the_journal_of_the_faults(file, target):
    world = World(slip=Fault(fault="drop", node="/again/lift"))
    with open_session(file, RunOptions(target=target, robot="fake")) as session:
        with injected(Resources(world=world), session.runner, session.runner.tell):
            session.runner.run()
        run = session.runner.run_id
    assert world.entries == ["/again/lift"] * 2
    with JournalReader(session.journal) as reader:
        said = [event.data["text"] for event in reader.iterate(run) if event.event == "message"]
    assert said == ["fault: slip: drop of mug"] * 2


def state_of(process):
    return Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()[0]


def test_a_component_hangs_goes_on_and_dies_and_none_is_left_hanging(file):
    process = subprocess.Popen(["sleep", "1000"])
    world = World(
        slow=Fault(fault="component_hang", of="grasps", lasts=1),
        stuck=Fault(fault="component_hang", of="grasps"),
        dead=Fault(fault="component_death", of="grasps"),
    )
    try:
        with open_session(file, RunOptions(robot="fake")) as session:
            resources = Resources(world=world, servers={"grasps": lambda: process.pid})
            with injected(resources, session.runner, session.runner.tell):
                for over, status in ((False, os.WIFSTOPPED), (True, os.WIFCONTINUED)):
                    world.on_fault("slow", "component_hang of grasps", over)
                    assert status(os.waitpid(process.pid, os.WUNTRACED | os.WCONTINUED)[1])
                world.on_fault("stuck", "component_hang of grasps", False)
                os.waitpid(process.pid, os.WUNTRACED)
            assert os.WIFCONTINUED(os.waitpid(process.pid, os.WCONTINUED)[1])
            with injected(resources, session.runner, session.runner.tell):
                world.on_fault("dead", "component_death of grasps", False)
                assert process.wait() == -signal.SIGKILL
    finally:
        process.kill()
        process.wait()


def test_a_fault_comes_during_a_run_and_wrong_ones_are_refused(file):
    world = World(slip=Fault(fault="drop", node="/again/lift"))
    with open_session(file, RunOptions(robot="fake")) as session:
        world.entered = lambda node: session.runner.inject("later: {fault: freeze}")
        heard, told = map(os.fdopen, os.pipe(), "rw")
        with heard, told, injected(Resources(world=world), session.runner, session.runner.tell):
            control = Control(heard, io.StringIO())
            control.attach(session.runner)
            control.start()
            told.write('{"command": "fault", "fault": "dark: {fault: blackout}"}\n')
            told.flush()
            until(lambda: world.injected, "the command")
            control.run()
            told.close()
            with pytest.raises(GripError, match="--fault"):
                session.runner.inject("slip: {fault: drop, node: again}")
            with pytest.raises(UnknownNameError, match="grasps"):
                session.runner.inject("dead: {fault: component_death, of: grasps}")
            with pytest.raises(DocumentError, match="'drop', 'push'"):
                session.runner.inject("slip: {fault: drip}")
        run = session.runner.run_id
    assert list(world.injected) == ["dark", "later"]
    with JournalReader(session.journal) as reader:
        said = [event.data["text"] for event in reader.iterate(run) if event.event == "message"]
    assert said == ["fault: later: freeze"] * 2


def test_a_run_without_a_simulated_world_takes_no_faults(file):
    with open_session(file, RunOptions(robot="fake")) as session, pytest.raises(GripError, match="simulated"):
        session.runner.inject("dark: {fault: blackout}")


def test_faults_are_given_as_in_a_worlds_file():
    given = [
        "slip: {fault: drop, node: lift, chance: 0.3}",
        "dark: {fault: blackout}, dim: {fault: light, factor: 0.5}",
    ]
    assert read_faults(given) == {
        "slip": Fault(fault="drop", node="lift", chance=0.3),
        "dark": Fault(fault="blackout"),
        "dim": Fault(fault="light", factor=0.5),
    }


@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        (["slip: {fault: drip}"], "'drop', 'push'"),
        (["slip: {fault: drop, nod: lift}"], "did you mean 'node'"),
        (["slip"], "slip"),
        (["a: {fault: drop}", "a: {fault: drop}"], "two faults are called 'a'"),
    ],
)
def test_what_is_no_fault_is_refused(given, wrong):
    with pytest.raises(DocumentError, match=wrong):
        read_faults(given)


def test_faults_need_a_node_that_is_there_and_a_simulated_world(file):
    for robot, node, error in (("sim", "lift", UnknownNameError), ("fake", "again/lift", GripError)):
        options = RunOptions(robot=robot, faults={"slip": Fault(fault="drop", node=node)})
        with pytest.raises(error), open_session(file, options):
            pass
