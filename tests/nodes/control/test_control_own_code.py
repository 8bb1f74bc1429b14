"""`control`: the first child decides over the others, status in, status out."""

from __future__ import annotations

from typing import Any

import pytest
from control_world import CATALOG, World, leaf
from py_trees.common import Status
from pydantic import ValidationError

from grip_bt.compilers import to_machine
from grip_bt.nodes.control import Control
from grip_bt.runtime.engine import make_ticker
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Task
from grip_bt.task.validation import validate


class Turn(Control):
    """Ticks the first child; when it has failed, the second, and halts what still runs when it ends."""

    log: list[str]

    def initialise(self) -> None:
        self.log = [*getattr(self, "log", []), "kept" if self.kept else "new"]

    def decide(self) -> str:
        first, *others = self.below
        end = first.tick()
        return others[0].tick() if end == "failure" and others else end

    def halted(self) -> None:
        self.log.append("halted")


class Deciding(World):
    """A world in which leaves called `by` decide."""

    def _make(self, path: str, node: Any, manifest: Any) -> Any:
        if path.rpartition("/")[2] != "by":
            return super()._make(path, node, manifest)
        return Turn(path, path, manifest, {}, {})


def control(**children: Any) -> dict[str, Any]:
    return {"kind": "control", "children": {"by": leaf(), **children}}


def test_the_first_child_ticks_the_others_and_its_end_is_the_containers() -> None:
    world = Deciding(control(a=leaf(), b=leaf()), {"a": "failure", "b": ".success"})
    assert [world.tick(), world.tick()] == [Status.RUNNING, Status.SUCCESS]
    assert world.ticked == ["a", "b", "a", "b"]


def test_the_engine_ticks_it_as_py_trees_does_and_a_halt_reaches_all() -> None:
    world = Deciding(control(a=leaf()), {"a": "..success"})
    tick = make_ticker(world.root)
    tick()
    world.root.stop(Status.INVALID)
    assert (world.ticked, world.halted) == (["a"], ["a"])
    assert world.root.children[0].log == ["new", "halted"]


def test_an_inner_one_learns_whether_it_was_reset_since_its_last_end() -> None:
    world = Deciding(control(inner=control(a=leaf())), {"inner/a": "success"})
    world.tick()
    world.tick()
    inner = world.root.children[1].children[0]
    assert inner.log == ["new", "new"]  # whoever ends resets what it has ticked


def test_exits_of_the_leaf_are_outcomes_and_machines_embed_it() -> None:
    root = {
        **control(a=leaf()),
        "outcomes": {"none": "success"},
        "exits": {"by.none": "none"},
        "on": {"none": "success"},
    }
    task = Task.model_validate({"grip": 1, "name": "t", "root": root})
    assert not validate(task, CATALOG).errors
    assert to_machine(task, CATALOG, leaf_factory=Deciding(root)._make).leaves.keys() == {"by", "a"}


def test_what_is_first_has_to_be_a_leaf() -> None:
    with pytest.raises(ValidationError, match="has to be a leaf"):
        Task.model_validate({"grip": 1, "name": "t", "root": {"kind": "control", "children": {"a": control()}}})


def test_what_the_leaf_writes_with_every_end_is_there_for_the_others() -> None:
    root = {
        "kind": "control",
        "children": {
            "by": {"node": "btcpp/LoopInt", "in": {"queue": "items"}, "out": {"value": "item"}},
            "say": {"node": "flow/log", "with": {"message": "item"}, "in": {"value": "item"}},
        },
    }
    data = {"items": {"type": "list[int]", "value": [1]}, "item": "Any"}
    task = Task.model_validate({"grip": 1, "name": "t", "data": data, "root": root})
    assert [issue.code for issue in validate(task, Catalog.builtin()).errors] == []
