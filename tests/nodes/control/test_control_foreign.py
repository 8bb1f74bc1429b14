"""Somebody's own behaviours: made when the task is compiled, ticked as they are, refused in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import pytest
from control_world import World
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import DocumentError, InvalidTaskError, NodeError
from grip_bt.compilers.binding import adopter
from grip_bt.task import loads
from grip_bt.task.catalog import AllowedImports
from grip_bt.task.model import Foreign


class Steps(Behaviour):
    """Runs so many ticks, then fails with a message; notes its life."""

    log: ClassVar[list[str]] = []

    def __init__(self, name: str, steps: int):
        super().__init__(name)
        self.steps = steps

    def setup(self, **kwargs: Any) -> None:
        self.log.append(f"setup {self.name} {sorted(kwargs)}")

    def initialise(self) -> None:
        self.left = self.steps

    def update(self) -> Status:
        if self.steps < 0:
            raise RuntimeError("broken")
        self.left -= 1
        self.feedback_message = f"{self.left} left"
        return Status.RUNNING if self.left else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        self.log.append(f"terminate {new_status.name}")


def number() -> int:
    return 3


def made(name: str, steps: int) -> Steps:
    return Steps(name, steps)


def foreign(what: str = "Steps", **args: Any) -> dict[str, Any]:
    return {"kind": "foreign", "behaviour": f"{__name__}:{what}", "args": args}


def test_a_foreign_behaviour_keeps_its_life_cycle_and_its_message_is_the_reason() -> None:
    Steps.log.clear()
    world = World({"kind": "sequence", "children": {"mine": foreign(steps=2)}})
    assert world.run() == 2
    assert Steps.log == ["setup mine ['context']", "terminate FAILURE"]
    assert (world.root.outcome, world.reason, str(world.root.failure)) == ("failure", "foreign", "foreign: 0 left")
    assert ("exit", "mine", "failure") in world.events


def test_a_foreign_behaviour_is_halted_with_its_container() -> None:
    Steps.log.clear()
    world = World({"kind": "timeout", "seconds": 1, "child": {"mine": foreign(steps=9)}})
    world.tick()
    world.clock.advance(1)
    assert world.tick() == Status.FAILURE
    assert Steps.log[-1] == "terminate INVALID"


def test_what_a_foreign_behaviour_raises_is_an_error_of_its_node() -> None:
    world = World({"kind": "sequence", "children": {"mine": foreign(steps=-1)}})
    with pytest.raises(NodeError, match="mine: RuntimeError: broken"):
        world.tick()


@pytest.mark.parametrize(
    ("node", "words"),
    [
        ({"behaviour": "no_such_module:Thing"}, "can't be imported: ModuleNotFoundError"),
        (foreign("Missing"), "can't be imported: AttributeError"),
        (foreign(), "can't be made of `args`: TypeError"),
        (foreign("number"), "makes a int, not a py_trees Behaviour"),
        (foreign("World"), "is a class, not a Behaviour of py_trees"),
        (foreign("foreign"), "is a function, which is called only if the project lists it by its name"),
        (foreign("__doc__"), "is a str, not a Behaviour of py_trees"),
        ({"behaviour": "py_trees.display:unicode_tree"}, "is a function, which is called only if the project lists it"),
        ({"behaviour": "py_trees.display:os.system"}, "is a function, which is called only if the project lists it"),
    ],
)
def test_what_cant_be_made_isnt_compiled(node: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidTaskError, match="unknown-behaviour") as caught:
        World({"kind": "foreign", **node})
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "behaviour", ["os:system", "subprocess:Popen", "test_control_foreigner:Steps", "py_trees_own:X"]
)
def test_what_the_project_doesnt_list_is_neither_imported_nor_called(behaviour: str, tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    with pytest.raises(InvalidTaskError, match="unlisted-code"):
        World({"kind": "foreign", "behaviour": behaviour, "args": {"command": f"touch {mark}"}})
    assert not mark.exists()


def test_a_listed_function_makes_a_behaviour_and_a_listed_class_is_enough_for_itself() -> None:
    node = Foreign.model_validate({"kind": "foreign", "behaviour": f"{__name__}:made", "args": {"steps": 3}})
    with pytest.raises(InvalidTaskError, match="unlisted-code"):
        adopter(AllowedImports((f"{__name__}:Steps",)))("/", "mine", node)
    assert adopter(AllowedImports((f"{__name__}:made",)))("/", "mine", node).steps == 3


def test_an_import_path_is_a_module_and_a_name() -> None:
    with pytest.raises(DocumentError, match="isn't an import path"):
        loads("grip: 1\nname: t\nroot: {kind: foreign, behaviour: 'os.system(1)'}\n", "t.yaml")
