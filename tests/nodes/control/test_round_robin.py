"""Round robin: whose turn it is, in every form of a task."""

from __future__ import annotations

from control_world import CATALOG, World, leaf
from py_trees.common import Status
from timed import ManualClock

from grip_bt.compilers import Rushing, to_machine
from grip_bt.runtime import RunContext
from grip_bt.runtime.engine import make_ticker
from grip_bt.task.model import Task

TURNS = {"kind": "round_robin", "children": {name: leaf() for name in "abc"}}


def times(count: int) -> dict[str, object]:
    return {"kind": "repeat", "times": count, "child": {"turns": TURNS}}


def test_each_activation_runs_the_next_child_and_begins_again_after_the_last() -> None:
    world = World(times(5))
    world.run()
    assert [path.rpartition("/")[2] for path in world.ticked] == list("abcab")


def test_the_tick_engine_and_the_machine_take_the_same_turns() -> None:
    world = World(times(5))
    tick = make_ticker(world.root)
    for _ in range(5):
        tick()
    assert [path.rpartition("/")[2] for path in world.ticked] == list("abcab")
    ran: list[str] = []
    task = Task.model_validate({"grip": 1, "name": "turns", "root": times(5)})
    machine = to_machine(task, CATALOG, leaf_factory=World(times(1))._make)
    machine.prepare(RunContext(ManualClock()))
    for path, node in machine.leaves.items():
        node.initialise = lambda path=path, node=node: (ran.append(path[-1]), type(node).initialise(node))
    assert machine.execute(Rushing()).outcome == "success"
    assert ran == list("abcab")


def test_it_ends_as_the_child_and_a_halted_child_has_had_its_turn() -> None:
    world = World(TURNS, {"a": ".success", "b": "failure.no_ik"})
    assert world.tick() == Status.RUNNING
    world.root.stop(Status.INVALID)
    assert (world.tick(), world.reason, world.ticked) == (Status.FAILURE, "no_ik", ["a", "b"])
