"""Trees in machines, machines in trees, to any depth: values go in and out, requests and stops reach what runs."""

from __future__ import annotations

import threading
from typing import Any

import py_trees
import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from grip_bt import smach_compat as smach
from grip_bt.base.errors import NodeError
from grip_bt.compilers import Halted, to_machine, to_tree
from grip_bt.nodes import Leaf
from grip_bt.nodes.smach_leaf import SmachLeaf
from grip_bt.runtime import BehaviourTree, Choose, RunContext, Runner, TreeRun
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import Task

WAITING = Manifest(
    id="test/waits",
    doc="Runs until it is asked to stop.",
    implementation="tests:Waits",
    outcomes={"stopped": "success"},
)
LEGACY = Manifest(id="test/legacy", doc="A machine.", implementation="tests:Legacy", outcomes={"over": "success"})
CATALOG = Catalog.builtin().with_manifests([WAITING, LEGACY])
PATIENCE = 120.0  # [s] far beyond what any of this takes


@pytest.fixture(autouse=True)
def silence() -> None:
    quiet = lambda text: None  # noqa: E731
    smach.set_loggers(quiet, quiet, quiet, quiet)


class Waits(Leaf):
    """Waits until a request for a preempt is seen."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.began, self.halted = threading.Event(), threading.Event()

    def update(self) -> Status:
        self.began.set()
        return self.end("stopped") if self.context.preempt_requested else self.running()

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.began.is_set():
            self.halted.set()


def counting(limit: int) -> Task:
    step = {"node": "flow/compute", "with": {"expression": "a + 1"}, "in": {"a": "count"}, "out": {"value": "count"}}
    return Task.model_validate(
        {
            "grip": 1,
            "name": "count",
            "inputs": {"count": "int"},
            "outputs": {"count": "int"},
            "root": {"kind": "loop", "while": f"count < {limit}", "child": {"step": step}},
        }
    )


def test_a_tasks_ports_are_keys_of_the_state_and_its_outcomes_are_the_states():
    machine = smach.StateMachine(["over", "broken"])
    machine.userdata.number = 3
    with machine:
        state = BehaviourTree(counting(7))
        smach.StateMachine.add("COUNT", state, {"success": "over", "failure": "broken"}, remapping={"count": "number"})
    assert (machine.execute(), machine.userdata.number) == ("over", 7)
    machine.userdata.number = 5
    assert (machine.execute(), machine.userdata.number) == ("over", 7)
    assert set(state.get_registered_outcomes()) == {"success", "failure"}


def test_a_tree_of_py_trees_reads_and_writes_keys_on_its_blackboard():
    class Double(py_trees.behaviour.Behaviour):
        def update(self) -> Status:
            Blackboard.set("twice", 2 * Blackboard.get("value"))
            return Status.SUCCESS

    machine = smach.StateMachine(["over"])
    machine.userdata.value = 21
    with machine:
        state = BehaviourTree(Double("double"), input_keys=["value"], output_keys=["twice"])
        smach.StateMachine.add("DOUBLE", state, {"success": "over", "failure": "over", "preempted": "over"})
    assert (machine.execute(), machine.userdata.twice) == ("over", 42)


def test_a_preempted_tree_of_py_trees_is_interrupted_at_once():
    ticked, ended = threading.Event(), []

    class Endless(py_trees.behaviour.Behaviour):
        def update(self) -> Status:
            ticked.set()
            return Status.RUNNING

        def terminate(self, new_status: Status) -> None:
            ended.append(new_status)

    machine = smach.StateMachine(["over", "preempted"])
    with machine:
        state = BehaviourTree(py_trees.composites.Sequence("all", memory=True, children=[Endless("endless")]))
        smach.StateMachine.add("RUN", state, {"success": "over", "failure": "over", "preempted": "preempted"})
    found: list[str] = []
    thread = threading.Thread(target=lambda: found.append(machine.execute()), daemon=True)
    thread.start()
    assert ticked.wait(PATIENCE)
    machine.request_preempt()
    thread.join(PATIENCE)
    assert found == ["preempted"]
    assert Status.INVALID in ended
    assert not state.preempt_requested()


class World:
    """A task, a legacy machine in it, a tree in that, and so on: `depth` machines, with one leaf at the bottom."""

    def __init__(self, depth: int):
        self.waits: list[Waits] = []
        self.depth = depth
        self.context = RunContext()

    def task(self, depth: int) -> Task:
        node = "test/legacy" if depth else "test/waits"
        outcomes = {"over": "success"} if depth else {"stopped": "success"}
        return Task.model_validate({"grip": 1, "name": f"level_{depth}", "outcomes": outcomes, "root": {"node": node}})

    def factory(self, depth: int) -> Any:
        def make(path: str, node: Any, manifest: Manifest) -> Leaf:
            if manifest is WAITING:
                self.waits.append(Waits(path, path, manifest, {}, {}))
                return self.waits[-1]
            leaf = SmachLeaf(path, path, manifest, {}, {})
            leaf.make = lambda: self.machine(depth - 1)  # type: ignore[method-assign]
            return leaf

        return make

    def machine(self, depth: int) -> smach.StateMachine:
        inner, outer = smach.StateMachine(["over"]), smach.StateMachine(["over"])
        run = TreeRun(self.context, CATALOG, leaf_factory=self.factory(depth))
        tree = BehaviourTree(self.task(depth), run)
        with inner:
            smach.StateMachine.add("TREE", tree, {o: "over" for o in tree.get_registered_outcomes()})
        with outer:
            smach.StateMachine.add("INNER", inner, {"over": "over"})
        return outer


@pytest.mark.parametrize("depth", [1, 2, 3])
@pytest.mark.parametrize("compile_task", [to_tree, to_machine])
@pytest.mark.parametrize("how", ["preempt", "halt"])
def test_requests_and_stops_reach_a_leaf_below_machines_in_trees_in_machines(depth, compile_task, how):
    world = World(depth)
    compiled = compile_task(world.task(depth), CATALOG, leaf_factory=world.factory(depth))
    runner = Runner(compiled, world.context)
    found: list[Any] = []
    thread = threading.Thread(target=lambda: found.append(runner.run()), daemon=True)
    thread.start()
    for _ in range(int(PATIENCE * 100)):
        if world.waits and world.waits[-1].began.wait(0.01):
            break
        thread.join(0.005)
    (leaf,) = world.waits
    assert leaf.began.is_set()
    runner.request_preempt() if how == "preempt" else runner.stop()
    thread.join(PATIENCE)
    (result,) = found
    if how == "preempt":
        assert (result.outcome, leaf.halted.is_set()) == ("over", False)
    else:
        assert result.status == "stopped"
        assert leaf.halted.wait(PATIENCE)


def test_a_machine_that_was_halted_in_a_tree_runs_again():
    world = World(1)
    leaf = SmachLeaf("legacy", "legacy", LEGACY, {}, {})
    leaf.make = lambda: world.machine(0)  # type: ignore[method-assign]
    leaf.setup(context=world.context)
    for number in (1, 2):
        leaf.tick_once()
        for _ in range(int(PATIENCE * 100)):
            if world.waits[-1].began.wait(0.01):
                break
            leaf.tick_once()
        waits = world.waits[-1]
        assert waits.began.is_set()
        assert leaf.status == Status.RUNNING, number
        leaf.stop(Status.INVALID)
        assert waits.halted.wait(PATIENCE)
        waits.began.clear()
        waits.halted.clear()


def test_a_stopped_run_ends_every_tree_of_its_machine():
    world = World(0)
    run = TreeRun(world.context, CATALOG, leaf_factory=world.factory(0))
    machine = smach.Concurrence(["over"], "over")
    with machine:
        for label in "AB":
            smach.Concurrence.add(label, BehaviourTree(world.task(0), run))
    raised: list[BaseException] = []

    def execute() -> None:
        try:
            machine.execute()
        except BaseException as error:  # noqa: BLE001 - looked at below
            raised.append(error)

    thread = threading.Thread(target=execute, daemon=True)
    thread.start()
    assert all(leaf.began.wait(PATIENCE) for leaf in world.waits)
    run.halt()
    thread.join(PATIENCE)
    assert [type(error) for error in raised] == [Halted]
    assert all(leaf.halted.is_set() for leaf in world.waits)


def test_an_error_names_the_node_by_its_place_in_the_whole_task():
    with TreeRun() as run:
        node = {"kind": "sequence", "children": {"sum": {"node": "flow/compute", "with": {"expression": "1 / 0"}}}}
        state = BehaviourTree.of_node(node, run, place="attempt/reckon")
        with pytest.raises(NodeError, match="attempt/reckon/sum"):
            state.execute(smach.UserData())


def test_failure_codes_can_be_outcomes_of_their_own():
    with TreeRun() as run:
        node = {"node": "flow/fail", "with": {"code": "no_ik"}}
        state = BehaviourTree.of_node(node, run, outcomes={"failure": "failure"}, codes=["failure.no_ik"])
        assert list(state.get_registered_outcomes()) == ["failure", "failure.no_ik"]
        assert state.execute(smach.UserData()) == "failure.no_ik"


def test_a_state_that_chooses_reads_userdata_and_says_what_is_wrong():
    with TreeRun() as run:
        cases = {"kind": "switch", "on_value": "n % 3", "cases": {"a": [0, 1]}}
        switch = Choose(run, cases, ["a"], place="pick", codes=["failure.no_case"])
        data = smach.UserData()
        data.n = 4
        assert switch.execute(data) == "do a"
        data.n = 5
        assert switch.execute(data) == "failure.no_case"
        assert {name for name in switch.get_registered_outcomes() if name.startswith("do ")} == {"do a"}
        other = Choose(run, {**cases, "default": "b"}, ["a", "b"], place="pick")
        assert {name for name in other.get_registered_outcomes() if name.startswith("do ")} == {"do a", "do b"}
        assert other.execute(data) == "do b"
        loop = Choose(run, {"kind": "loop", "while": "n < 7", "times": 1}, ["a"])
        assert [loop.execute(data), loop.execute(data)] == ["do a", "failure"]
        data.n = 7
        assert loop.execute(data) == "success"
        with pytest.raises(NodeError, match="pick: .*variable 'n' was read before it was written"):
            switch.execute(smach.UserData())
