"""Somebody's own tree under the runner: it does what it does under py_trees alone, and the journal has it."""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path
from random import Random
from typing import Any

import pytest
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.trees import BehaviourTree
from random_trees import make_tree

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.errors import GripError, NodeError
from grip_bt.cli.project import drawing_of
from grip_bt.compilers import Rushing
from grip_bt.formats.pytrees import import_from_code
from grip_bt.formats.pytrees.adopted import AdoptedTree
from grip_bt.formats.pytrees.tree import drawn
from grip_bt.nodes.dry_run import StoodIn, dry_run_of_tree
from grip_bt.nodes.node import Observer
from grip_bt.nodes.tree_code import FoundTree, find_tree, is_of_ros, is_tree_code, place_of
from grip_bt.runtime import JournalReader
from grip_bt.task import dumps, walk
from grip_bt.task.validation import validate

CODE = """\
import operator
import py_trees
from py_trees.blackboard import Blackboard
from py_trees.common import Access, ComparisonExpression, Status


class Measure(py_trees.behaviour.Behaviour):
    def __init__(self, name, where):
        super().__init__(name)
        self.where = where
        self.board = self.attach_blackboard_client(namespace="battery")
        self.board.register_key("level", Access.WRITE, remap_to="/charge")
        self.board.register_key("log", Access.WRITE)

    def setup(self, **given):
        self.given = given

    def initialise(self):
        self.board.level = 30
        self.board.log = []

    def update(self):
        self.board.log.append("looked")
        self.board.level -= 10
        self.feedback_message = f"{self.board.level} %"
        return Status.RUNNING if self.board.level else Status.FAILURE


class Twice(py_trees.decorators.Decorator):
    def update(self):
        return self.decorated.status


def create_root(where="dock", extra=None):
    check = ComparisonExpression("charge", 15, operator.lt)
    low = py_trees.behaviours.CheckBlackboardVariableValue("low?", check)
    root = py_trees.composites.Parallel("watch", py_trees.common.ParallelPolicy.SuccessOnOne())
    root.add_children([Twice("twice", Measure("measure", where)), py_trees.decorators.Inverter("fine?", low)])
    return py_trees.composites.Sequence("root", True, [root])


def needs(height):
    return create_root(height)


def main():
    tree = py_trees.trees.BehaviourTree(create_root())
    tree.setup()
    tree.add_post_tick_handler(lambda tree: Blackboard.set("handled", tree.count))
    try:
        tree.tick_tock(period_ms=20, pre_tick_handler=lambda tree: None)
    finally:
        tree.shutdown()


if __name__ == "__main__":
    main()
"""


@pytest.fixture
def code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    Blackboard.clear()
    monkeypatch.setattr(sys, "path", [*sys.path])
    file = tmp_path / "my_tree.py"
    file.write_text(textwrap.dedent(CODE))
    yield file
    sys.modules.pop("my_tree", None)
    Blackboard.clear()


def ran(where: str, **options: Any) -> tuple[Any, list[Any]]:
    """Run a tree; return the result and what the journal has."""
    with open_session(where, RunOptions(robot="fake", **options)) as session:
        result = session.runner.run()
    with JournalReader(session.journal) as reader:
        return result, list(reader.events(session.runner.run_id))


def test_a_tree_runs_as_it_is_and_the_journal_has_its_nodes_and_its_blackboard(code: Path) -> None:
    result, events = ran(f"{code}:create_root")
    assert (result.status, result.ticks) == ("success", 1)  # that the charge isn't low is a success at once
    paths = [(event.event, event.path) for event in events if event.event in ("enter", "exit", "interrupted")]
    assert paths == [
        *(("enter", path) for path in ("/", "watch", "watch/twice", "watch/twice/measure")),
        *(("enter", path) for path in ("watch/fine?".replace("?", ""), "watch/fine/low")),
        *(("exit", path) for path in ("watch/fine/low", "watch/fine")),
        *(("interrupted", path) for path in ("watch/twice/measure", "watch/twice")),
        *(("exit", path) for path in ("watch", "/")),
    ]
    written = {event.data["variable"]: event.path for event in events if event.event == "write"}
    assert written == {"charge": "watch/twice/measure", "battery_log": "watch/twice/measure"}
    assert [event.data["text"] for event in events if event.event == "message"] == ["20 %"]


def test_a_program_is_caught_at_its_first_tick_with_its_handlers_and_its_period(code: Path) -> None:
    found = find_tree(place_of(str(code)))
    assert (found.ready, found.period, found.tree.count) == (True, 0.02, 0)
    assert len(found.tree.pre_tick_handlers) == len(found.tree.post_tick_handlers) == 1
    result, events = ran(f"{code}:main", ticks=3)
    assert result.ticks == 3
    handled = [event.path for event in events if event.event == "write" and event.data["variable"] == "handled"]
    assert handled == ["/"] * 3


def test_breakpoints_hold_a_tree_in_its_tick_and_see_its_blackboard(code: Path) -> None:
    with open_session(f"{code}:create_root", RunOptions(robot="fake")) as session:
        held: list[str] = []
        session.runner.debugger.set("watch/fine", condition="charge < 25")
        session.runner.debugger.on_held(lambda at: (held.append(at.path), session.runner.resume()))
        assert session.runner.run().status == "success"
    assert held == ["watch/fine"]


@pytest.mark.parametrize(
    ("where", "said"),
    [
        (":needs", r"needs takes 'height': give it as a literal, `.*my_tree.py:needs\(height=...\)`"),
        (":nothing", "has no 'nothing' .*create_root, needs, main"),
        (":Status", "takes 'value'|argument: 'value'|makes no tree"),
        (":create_root(where=x)", "arguments are literals by name"),
    ],
)
def test_what_makes_no_tree_is_told(code: Path, where: str, said: str) -> None:
    with pytest.raises(GripError, match=said):
        find_tree(place_of(f"{code}{where}"))
    with pytest.raises(GripError, match="no such file"):
        find_tree(place_of("nowhere.py:create_root"))


def test_arguments_are_given_as_literals(code: Path) -> None:
    tree = find_tree(place_of(f"{code}:create_root(where='shelf', extra=[1, 2])")).tree
    assert tree.root.children[0].children[0].children[0].where == "shelf"


def test_options_of_tasks_are_refused(code: Path) -> None:
    for options in ({"target": "sm"}, {"data": {"a": 1}}):
        with pytest.raises(GripError, match="is for tasks"), open_session(f"{code}:create_root", RunOptions(**options)):
            pass


class Noted(Observer):
    """Which nodes were active, and whether ends and beginnings fit."""

    def __init__(self) -> None:
        self.active: set[str] = set()

    def entered(self, path: str) -> None:
        assert path not in self.active
        self.active.add(path)

    def ended(self, path: str, outcome: str, failure: object) -> None:
        self.active.remove(path)

    def interrupted(self, path: str) -> None:
        self.active.remove(path)


@pytest.mark.parametrize("seed", range(60))
def test_random_trees_have_the_same_statuses_and_their_events_fit(seed: int) -> None:
    def statuses(adopted: bool) -> list[Any]:
        Blackboard.clear()
        Blackboard.set("z", 0)
        tree, seen = BehaviourTree(make_tree(Random(seed))), []
        tree.add_post_tick_handler(lambda tree: seen.append([node.status for node in tree.root.iterate()]))
        if not adopted:
            for _ in range(8):
                tree.tick()
            return seen
        compiled, noted = AdoptedTree(FoundTree(tree), "here", ticks=8), Noted()
        compiled.observe(noted)
        compiled.execute(Rushing())
        assert noted.active == set()
        assert not any(name in vars(node) for node in tree.root.iterate() for name in ("tick",) if compiled.release())
        return seen

    assert statuses(adopted=True) == statuses(adopted=False)


def test_a_behaviour_that_raises_is_named(code: Path) -> None:
    class Broken(Behaviour):
        def update(self) -> Status:
            raise ZeroDivisionError

    compiled = AdoptedTree(FoundTree(BehaviourTree(Broken("broken"))), "here")
    with pytest.raises(NodeError, match="/: ZeroDivisionError"):
        compiled.execute(Rushing())


def test_a_drawing_runs_the_tree_that_its_project_lists(code: Path) -> None:
    task = drawn(find_tree(place_of(f"{code}:create_root")).tree.root, f"{code}:create_root")[0]
    assert task.root.children["watch"].kind == "parallel"
    twice = task.root.children["watch"].children["twice"]
    assert (twice.behaviour, twice.children["measure"].args) == ("my_tree:Twice", {"where": "dock"})
    measure = twice.children["measure"]
    assert measure.out == {"/battery/level is /charge": "charge", "/battery/log": "battery_log"}
    file = code.parent / "drawing.yaml"
    file.write_text("# drawn\n" + dumps(task))
    assert validate(task, catalogue_of(find_project(file))).errors == ()
    with pytest.raises(GripError, match="doesn't list: `code: .'my_tree:create_root'"):
        ran(str(file))
    (code.parent / "grip.yaml").write_text("grip: 1\ncode: ['my_tree:create_root']\n")
    result, events = ran(str(file))
    assert result.status == "success"
    assert {event.path for event in events if event.event == "exit"} <= {path for path, _ in walk(task.root)}


METHODS = """\
import argparse
import asyncio
from py_trees import behaviours, composites, trees


class Task:
    def __init__(self, speed, robot=None):
        self.speed, self.robot = speed, robot

    def make(self, times):
        return composites.Sequence(f"{self.speed} {times}", True, [behaviours.Success("go")])


async def later(robot):
    await asyncio.sleep(0)
    return behaviours.Success(f"{robot}")


class Away(behaviours.Success):
    def shutdown(self):
        raise RuntimeError("is gone")


def away():
    return Away("away")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--level", type=int, required=True)
    trees.BehaviourTree(behaviours.Success(f"level {parser.parse_args().level}")).tick()


if __name__ == "__main__":
    main()
"""


@pytest.fixture
def methods(code: Path) -> Path:
    file = code.parent / "methods.py"
    file.write_text(METHODS)
    yield file
    sys.modules.pop("methods", None)


def test_a_method_is_one_of_an_object_that_is_made_for_it(methods: Path) -> None:
    assert find_tree(place_of(f"{methods}:Task.make(times=3, speed='slow')")).tree.root.name == "slow 3"
    with pytest.raises(GripError, match=r"takes 'speed': give it as a literal, .*or use --stand-ins"):
        find_tree(place_of(f"{methods}:Task.make(times=3)"))
    with pytest.raises(GripError, match=r"makes no tree of py_trees but a Task \(there are: Task.make\)"):
        find_tree(place_of(f"{methods}:Task(speed=1)"))


def test_a_program_gets_its_command_line(methods: Path) -> None:
    for where in (f"{methods} --level 3", f"{methods}:main --level 3"):
        assert is_tree_code(where)
        assert find_tree(place_of(where)).tree.root.name == "level 3"
    with pytest.raises(GripError, match=r"SystemExit: 2; what its command line needs goes behind it"):
        find_tree(place_of(str(methods)))


THREADED = """\
import time
from concurrent.futures import ThreadPoolExecutor
from py_trees import behaviours, trees


class Older(behaviours.Success):
    def setup(self, timeout):
        self.timeout = timeout


tree = trees.BehaviourTree(Older("older"))
tree.setup(timeout=3.0)
ThreadPoolExecutor().submit(tree.tick)
while True:
    time.sleep(0.001)
"""


def test_a_program_is_left_by_the_first_tick_of_any_thread(code: Path) -> None:
    code.write_text(THREADED)
    found = find_tree(place_of(str(code)))
    assert (found.ready, found.tree.root.timeout > 0, found.tree.count) == (True, True, 0)


def test_stand_ins_are_given_for_arguments_that_nobody_gave(methods: Path) -> None:
    with dry_run_of_tree(lambda what: None, methods):
        assert find_tree(place_of(f"{methods}:later")).tree.root.name == "<robot>"
        assert find_tree(place_of(f"{methods}:Task.make(times=2)")).tree.root.name == "<speed> 2"


def test_what_a_tree_raises_in_the_end_leaves_the_result(methods: Path) -> None:
    result, _ = ran(f"{methods}:away")
    assert (result.status, result.outcome) == ("success", "success")


OLDER = """\
import arm_driver
import launch
from helpers.legs import Step
from our_msgs.msg import Speed
from py_trees import behaviours, composites, decorators
from sibling.walking import Walk
from py_trees.common import ParallelPolicy


def bring_up() -> launch.LaunchDescription:
    return launch.LaunchDescription([])


def create_root():
    both = composites.Parallel("both", policy=ParallelPolicy.SUCCESS_ON_ONE)
    both.add_children([behaviours.Running("run"), composites.Selector(children=[arm_driver.Lift("up")])])
    first = composites.Sequence("first")
    held = decorators.Inverter(decorators.Inverter(arm_driver.Hold("hold")))
    first.add_children([behaviours.Success("look"), held, Walk(Step, Speed()), both])
    return first
"""
SIBLING = """\
from py_trees.behaviours import Success


class Walk(Success):
    def __init__(self, step, speed):
        super().__init__("walk")
"""


@pytest.fixture
def older(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workspace with a package that isn't installed, one of messages that isn't built, and one that lacks a part."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    before = {*sys.modules}
    files = {
        **{
            f"{name}/package.xml": f"<package><name>{name}</name></package>"
            for name in ("walks", "sibling", "our_msgs")
        },
        "walks/older.py": OLDER,
        "walks/launch/walk_launch.py": "",
        "sibling/sibling/__init__.py": "",
        "sibling/sibling/walking.py": SIBLING,
        "our_msgs/msg/Speed.msg": "float32 speed",
        "walks/helpers/__init__.py": "",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    yield tmp_path / "walks" / "older.py"
    for name in {*sys.modules} - before:
        del sys.modules[name]


def test_a_tree_for_an_older_py_trees_runs_and_what_is_not_installed_is_stood_in_for(older: Path) -> None:
    with pytest.raises(GripError, match=r"No module named 'arm_driver', .* stand in for it with --stand-ins"):
        find_tree(place_of(f"{older}:create_root"))
    told = []
    options = RunOptions(journal=older.parent / "runs.sqlite", ticks=1, stand_ins=True)
    with open_session(f"{older}:create_root", options, lambda *words: told.append(words)) as session:
        tree: Any = session.runner.compiled
        memory = [each.memory for each in tree.root.iterate() if hasattr(each, "memory")]
        assert (session.runner.run().outcome, memory) == ("success", [False, True])
        names = {each.name: type(each) for each in tree.root.iterate()}
        assert names["up"] is names["hold"] is StoodIn
        assert names["walk"].__module__ == "sibling.walking"
    missing = {words for part, words in told if part == "stand-in"}
    assert missing == {f"package {name}" for name in ("arm_driver", "launch", "helpers", "our_msgs")}


def test_an_import_and_a_drawing_have_stand_ins_and_name_them(older: Path, capfd: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(older.parent)
    made = import_from_code("older.py:create_root", older.parent, stand_ins=True)
    assert [issue.message for issue in made.issues if issue.code == "stood-in"][:1] == ["package arm_driver"]
    kept = {path for path, node in walk(made.task.root) if getattr(node, "kind", "") == "foreign"}
    assert kept == {"Inverter/Inverter/hold", "both/Selector/up"}
    file = drawing_of("older.py:create_root", stand_ins=True)
    with open_session(file, RunOptions(robot="fake", ticks=1)) as session:
        assert session.runner.run().outcome == "success"


TAKEN_FOR_GRANTED = """\
import py_trees
import py_trees_ros
import std_msgs


def create_root():
    battery = py_trees_ros.battery.ToBlackboard(name="Battery", topic_name="/battery", threshold=30.0)
    event = py_trees_ros.subscribers.ToBlackboard("Abort", topic_type=std_msgs.msg.Bool)
    return py_trees.composites.Sequence("Topics", memory=True, children=[battery, event])
"""


def test_what_stands_in_is_called_as_it_was_and_py_trees_ros_brings_messages_along(tmp_path: Path) -> None:
    (tmp_path / "topics.py").write_text(TAKEN_FOR_GRANTED)
    made = import_from_code(f"{tmp_path}/topics.py:create_root", tmp_path, stand_ins=True)
    assert [*made.task.root.children] == ["Battery", "Abort"]


ROS = """\
import py_trees_ros.trees
from py_trees.behaviours import Success


class Ready(Success):
    def setup(self, **given):
        self.node = given["node"]


def main():
    tree = py_trees_ros.trees.BehaviourTree(root=Ready("ready"), unicode_tree_debug=True)
    tree.setup(timeout=15.0, node_name="robot")
    tree.tick_tock(period_ms=500)
    tree.node.spin()


if __name__ == "__main__":
    main()
"""


def test_the_tree_of_py_trees_ros_is_stood_in_for_by_one_that_ticks(older: Path) -> None:
    file = older.parent / "robot.py"
    file.write_text(ROS)
    with dry_run_of_tree(lambda what: None, file):
        found = find_tree(place_of(str(file)))
    assert (found.ready, found.period, found.tree.root.node is found.tree.node) == (True, 0.5, True)


@pytest.mark.parametrize(("given", "of_ros"), [("node", True), ("speed", False)])
def test_a_tree_that_takes_its_node_from_all_that_setup_is_given_is_one_of_ros(
    given: str, of_ros: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / f"takes_a_{given}.py").write_text(
        "from py_trees.behaviours import Success\n\n\nclass Ready(Success):\n"
        f"    def setup(self, **given):\n        self.kept = given['{given}']\n\n\n"
        "def create_root():\n    return Ready('ready')\n"
    )
    found = find_tree(place_of(f"{tmp_path}/takes_a_{given}.py:create_root"))
    assert is_of_ros(found.tree.root) is of_ros
