"""A tree becomes the task that does the same; a compiled task gives its document back; the rest is refused by name."""

from __future__ import annotations

import itertools
import operator
import os
from random import Random
from typing import Any

import py_trees
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from parity_generate import make_case
from parity_world import ScriptedLeaf, catalog_of
from py_trees import behaviours, composites, decorators, idioms
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Access, ParallelPolicy, Status
from random_trees import make_tree
from timed import ManualClock

from grip_bt.base.errors import InvalidTaskError
from grip_bt.compilers import CompiledTree, to_tree
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.formats.pytrees import to_task, told
from grip_bt.task import Task, dumps
from grip_bt.task.catalog import AllowedImports, Catalog
from grip_bt.task.model import Foreign, walk

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "200"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
STEP = {"node": "flow/succeed"}


class Context:
    """What leaves and time-outs ask for."""

    def __init__(self) -> None:
        self.clock = ManualClock()
        self.preempt_requested = False

    def wake(self) -> None:
        """Nobody waits."""

    def wake_at(self, time: float) -> None:
        """Nobody waits."""


def compiled(root: dict[str, Any], **task: Any) -> CompiledTree:
    return to_tree(Task.model_validate({"grip": 1, "name": "t", "root": root, **task}), Catalog.builtin())


@settings(max_examples=TASKS, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.randoms(use_true_random=False), st.integers(0, 14))
def test_a_compiled_task_gives_its_document_back(random: Random, flavour: int) -> None:
    case = make_case(flavour, random=random)
    task = Task.model_validate(case["task"])
    tree = to_tree(
        task, catalog_of(case), leaf_factory=lambda p, n, m: ScriptedLeaf(p, p, m, dict(n.with_), dict(n.meaning))
    )
    again = to_task(tree)
    assert again.task == task
    assert dumps(again.task) == dumps(task)
    assert again.issues == ()


def statuses(root: Behaviour) -> list[str]:
    return [node.status.name for node in root.iterate() if node.name.split()[:1] != ["inside"]]


def test_a_tree_and_its_task_have_the_same_statuses_at_every_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    context, readings = Context(), itertools.count()
    # A clock that is read twice never shows the same; so "after" and "not before" a deadline are one.
    for module in (py_trees.decorators, py_trees.timers):
        monkeypatch.setattr(module.time, "monotonic", lambda: context.clock.now() + next(readings) * 1e-9)
        monkeypatch.setattr(module.time, "time", lambda: context.clock.now() + next(readings) * 1e-9)
    kinds: set[str] = set()
    for seed in range(FIRST, FIRST + TASKS):
        context.clock = ManualClock()
        Blackboard.clear()
        Blackboard.set("x", seed % 3)
        Blackboard.set("z", 0)
        tree = make_tree(Random(seed))
        again = to_tree(to_task(tree, built_by="some:where").task, Catalog.builtin()).root
        assert len(statuses(again)) == len(statuses(tree))
        for node in again.iterate():
            node.setup(context=context)
        for tick in range(12):
            tree.tick_once()
            again.tick_once()
            assert statuses(again) == statuses(tree), f"seed {seed}, tick {tick}"
            context.clock.advance(1)
        kinds |= {type(node).__name__ for node in tree.iterate()}
    assert len(kinds) == 33


def test_either_or_chooses_by_what_is_on_the_blackboard_and_keeps_its_choice() -> None:
    def choice() -> Behaviour:
        wanted = [py_trees.common.ComparisonExpression(key, "enabled", operator.eq) for key in ("one", "two", "three")]
        tasks: list[Behaviour] = [behaviours.TickCounter(f"task {n}", 2, Status.SUCCESS) for n in range(3)]
        return idioms.either_or(wanted, tasks, namespace="chosen")

    for pressed in itertools.product(("enabled", "disabled"), repeat=3):
        Blackboard.clear()
        for key, value in zip(("one", "two", "three"), pressed, strict=True):
            Blackboard.set(key, value)
        tree = choice()
        task = to_task(tree).task
        assert not [node for _, node in walk(task.root) if isinstance(node, Foreign)]
        again, context = to_tree(task, Catalog.builtin()).root, Context()
        for node in again.iterate():
            node.setup(context=context)
        for _ in range(5):
            tree.tick_once()
            again.tick_once()
            assert statuses(again) == statuses(tree), pressed


def stuck() -> Behaviour:
    return behaviours.Running("stuck")


@pytest.mark.parametrize(
    ("node", "why"),
    [
        (lambda: decorators.RunningIsSuccess("x", stuck()), "RunningIsSuccess isn't a class that a task has"),
        (lambda: decorators.Condition("x", stuck(), Status.RUNNING), "a Condition that waits for RUNNING"),
        (lambda: decorators.EternalGuard("x", stuck(), lambda: stuck() is None), "its condition is a Python function"),
        (lambda: composites.Parallel("x", ParallelPolicy.SuccessOnSelected([])), "SuccessOnSelected"),
        (
            lambda: type("Mine", (composites.Sequence,), {"stop": lambda self: None})("x", True),
            "Mine can't be imported by a name",
        ),
    ],
)
def test_what_has_no_equal_is_refused_with_its_path_and_the_reason(node: Any, why: str) -> None:
    root = composites.Sequence("root", True, [behaviours.Success("fine"), decorators.Inverter("not", node())])
    with pytest.raises(ImportRefusedError, match=f"not/x: .*{why}"):
        to_task(root)


def test_all_refusals_are_found_at_once() -> None:
    with pytest.raises(ImportRefusedError) as caught:
        to_task(composites.Sequence("root", True, [Odd([]), decorators.RunningIsSuccess("count", Odd([object()]))]))
    assert [issue.path for issue in caught.value.issues] == ["count", "count/odd"]


class Odd(Behaviour):
    """Somebody's own."""

    def __init__(self, words: list, name: str = "odd", factor: float = 1.0, *, twice: bool = False):
        super().__init__(name)
        self.words, self.factor, self.twice = words, 2 * factor if twice else factor, False

    def update(self) -> Status:
        return Status.FAILURE


def test_a_behaviour_that_can_be_made_again_is_kept_as_it_is() -> None:
    children = [stuck(), Odd(["a", {"b": 1}], factor=2.5), Odd([], name="its own")]
    found = to_task(
        composites.Sequence("root", False, [*children, composites.Sequence("its-own", True, [Odd([], "7")])])
    )
    nodes = found.task.root.children
    assert nodes["stuck"].with_ == {"statuses": ["running"]}
    assert nodes["odd"].args == {"words": ["a", {"b": 1}], "factor": 2.5}
    assert nodes["its own"].args == {"words": []}
    assert nodes["its-own"].children["n_7"].args == {"words": [], "name": "7"}
    catalog = Catalog.builtin().with_(code=AllowedImports((__name__,)))
    again = [node for node in to_tree(found.task, catalog).root.iterate() if type(node) is Odd]
    assert [(node.name, node.words, node.factor) for node in again] == [
        ("odd", ["a", {"b": 1}], 2.5),
        ("its own", [], 1.0),
        ("7", [], 1.0),
    ]


@pytest.mark.parametrize(
    ("behaviour", "why"),
    [
        (lambda: Odd([], "x", 2.0, twice=True), "made again its 'later' would be another"),
        (lambda: behaviours.BlackboardToStatus("x", "key"), "BlackboardToStatus isn't a class that a task has"),
        (lambda: behaviours.SetBlackboardVariable("x", "key.attribute", 1, True), "is an attribute of what is on"),
        (lambda: behaviours.SetBlackboardVariable("x", "key", object(), True), "or an object"),
    ],
)
def test_a_behaviour_that_would_not_be_the_same_is_refused(behaviour: Any, why: str) -> None:
    made = behaviour()
    if isinstance(made, Odd):
        made.later = "set after it was made"
    with pytest.raises(ImportRefusedError, match=why):
        to_task(composites.Sequence("root", True, [made]))


def test_names_that_a_task_cannot_have_are_told() -> None:
    children = [behaviours.Success(name) for name in ("a.b", "a_b", "a.b", "7", "fine")]
    found = to_task(composites.Sequence("my tree!", True, children))
    assert list(found.task.root.children) == ["a_b_2", "a_b", "a_b_3", "n_7", "fine"]
    renamed = {issue.path: issue.message for issue in found.issues if issue.code == "renamed"}
    assert renamed == {"a_b_2": "was called 'a.b'", "a_b_3": "was called 'a.b'", "n_7": "was called '7'"}
    assert found.task.name == "my tree"


def test_a_tree_without_its_document_is_read_from_what_its_nodes_carry() -> None:
    tree = compiled(
        {
            "kind": "state_machine",
            "initial": "try",
            "outcomes": {"done": "success", "lost": "failure"},
            "children": {
                "try": {
                    "kind": "retry",
                    "times": 3,
                    "outcomes": {"late": "failure"},
                    "exits": {"fail.failure.no_ik": "late"},
                    "on": {"success": "done", "failure.time_out": "try", "failure": "lost", "late": "both"},
                    "child": {"fail": {"node": "flow/fail", "with": {"code": "no_ik"}}},
                },
                "both": {
                    "kind": "parallel",
                    "policy": "any",
                    "cancel": "join",
                    "on": {"success": "rest", "failure": "lost"},
                    "children": {"wait": {"node": "flow/wait", "with": {"seconds": 1}}, "step": STEP},
                },
                "rest": {
                    "kind": "cooldown",
                    "seconds": 2.0,
                    "on": {"success": "done", "failure": "lost"},
                    "child": {"loop": {"kind": "loop", "times": 3, "child": {"step": STEP}}},
                },
            },
        },
        outcomes={"done": "success", "lost": "failure"},
    )
    assert to_task(tree.root).task == tree.task


def test_variables_of_a_tree_without_its_document_are_refused() -> None:
    log = {"node": "flow/log", "with": {"message": "m"}, "in": {"value": "v"}}
    guard = {"kind": "guard", "if": "v > 1", "child": {"step": STEP}}
    children = {"log": log, "guard": guard, "if": {**STEP, "precondition": "v > 2"}}
    tree = compiled({"kind": "sequence", "data": {"v": {"type": "int", "value": 2}}, "children": children})
    assert to_task(tree).task == tree.task
    with pytest.raises(ImportRefusedError) as caught:
        to_task(tree.root)
    assert [issue.path for issue in caught.value.issues] == ["/", "log", "guard", "if"]


def test_what_was_changed_on_the_behaviours_is_in_the_document() -> None:
    tree = compiled(
        {
            "kind": "sequence",
            "doc": "All of it.",
            "children": {
                "again": {"kind": "retry", "times": 2, "doc": "Twice.", "child": {"step": STEP}},
                "wait": {"node": "flow/wait", "with": {"seconds": 1.5}},
                "gone": STEP,
            },
        }
    )
    root: Any = tree.root
    root.memory = False
    again = root.children[0]
    again.kind = again.kind.model_copy(update={"times": 5})
    root.children[1].params["seconds"] = 2.5
    root.remove_child(root.children[2])
    root.add_child(composites.Selector("new", True, [behaviours.Failure("no")]))
    changed = to_task(tree).task.root
    assert (changed.doc, changed.memory, list(changed.children)) == ("All of it.", False, ["again", "wait", "new"])
    assert (changed.children["again"].doc, changed.children["again"].times) == ("Twice.", 5)
    assert changed.children["wait"].with_ == {"seconds": 2.5}
    assert changed.children["new"].children["no"].node == "flow/fail"
    assert root.status == Status.INVALID


def test_what_comes_out_is_checked_like_any_task() -> None:
    tree = compiled(
        {"kind": "sequence", "outcomes": {"x": "success"}, "exits": {"a.success": "x"}, "children": {"a": STEP}}
    )
    tree.root.remove_child(tree.root.children[0])
    with pytest.raises(InvalidTaskError, match="'a.success' names no child"):
        to_tree(to_task(tree).task, Catalog.builtin())


@pytest.mark.parametrize("where", [":loads", ":", "", "a:b(1)", "a:b(c=d)"])
def test_a_place_that_cannot_be_read_is_told_how_it_is_written(where: str) -> None:
    assert "file.py:function" in told(where)["error"] or "literals by name" in told(where)["error"]


class SeesWhatIsDone(Behaviour):
    """One that stays as it is, and sees a key."""

    def __init__(self) -> None:
        super().__init__("sees")
        self.attach_blackboard_client().register_key("done", Access.READ)

    def update(self) -> Status:
        return Status.SUCCESS


def once() -> Behaviour:
    steps = [Status.RUNNING, Status.SUCCESS, Status.FAILURE]
    return idioms.oneshot(behaviours.StatusQueue("steps", steps, None), "once", "done")


def test_a_status_on_the_blackboard_is_a_text_where_no_kept_behaviour_sees_it() -> None:
    task = to_task(once()).task
    assert not [node for _, node in walk(task.root) if isinstance(node, Foreign)]
    mine, other, context = to_tree(task, Catalog.builtin()).root, once(), Context()
    for node in mine.iterate():
        node.setup(context=context)
    for _ in range(5):
        mine.tick_once()
        other.tick_once()
        assert statuses(mine) == statuses(other)
    with pytest.raises(ImportRefusedError, match="Python function returns, or an object"):
        to_task(composites.Selector("s", False, [SeesWhatIsDone(), once()]))


def test_a_value_that_has_the_word_of_its_key_stays_as_it_is() -> None:
    check = py_trees.common.ComparisonExpression("door", "the door is open", operator.eq)
    root = to_task(behaviours.WaitForBlackboardVariableValue("wait", check), built_by="m:f").task.root
    said: Any = root.model_dump(by_alias=True)
    assert (said["with"], said["in"]) == ({"expression": "a != null and a == 'the door is open'"}, {"a": "door"})
