"""Leaves of py_trees' own are ticked by compiled functions, which nobody can tell from theirs."""

from __future__ import annotations

import operator
import random
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from py_trees import behaviours, composites, decorators
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access, ComparisonExpression, Status

from grip_bt.runtime import Plan

S, F, R = Status.SUCCESS, Status.FAILURE, Status.RUNNING


@pytest.fixture
def board() -> Iterator[Client]:
    client = Client(name="test")
    for key in ("x", "y", "pose", "name"):
        client.register_key(key=key, access=Access.WRITE)
    yield client
    Blackboard.disable_activity_stream()
    Blackboard.clear()
    Blackboard.clients.clear()


def checking(value: Any, compare: Any = operator.eq, key: str = "x") -> behaviours.CheckBlackboardVariableValue:
    return behaviours.CheckBlackboardVariableValue("check", ComparisonExpression(key, value, compare))


def hot(root: Any, **options: Any) -> Plan:
    plan = Plan(root, **options)
    plan.optimise()
    return plan


@pytest.mark.parametrize("generated", [False, True])
def test_no_update_of_their_own_is_called_where_everything_is_as_usual(
    board: Client, generated: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    board.x, board.y, board.pose = 1, 2, SimpleNamespace(at=0, status=S)
    kids = [
        behaviours.Success("success"),
        checking(1),
        behaviours.CheckBlackboardVariableExists("exists", "x"),
        behaviours.WaitForBlackboardVariable("wait", "x"),
        behaviours.SetBlackboardVariable("set", "x", 1, True),
        behaviours.StatusQueue("queue", [S], S),
        behaviours.SuccessEveryN("every", 1),
        behaviours.WaitForBlackboardVariableValue("wait", ComparisonExpression("x", 1, operator.eq)),
        behaviours.CheckBlackboardVariableExists("exists", "x.real"),
        behaviours.CompareBlackboardVariables("two", "x", "y", operator.lt),
        behaviours.CheckBlackboardVariableValues(
            "all", [ComparisonExpression(key, 1, operator.ge) for key in ("x", "y.real")], operator.and_
        ),
        behaviours.SetBlackboardVariable("set", "pose.at", 7, True),
        behaviours.BlackboardToStatus("status", "pose.status"),
        behaviours.UnsetBlackboardVariable("unset", "y"),
    ]
    root = composites.Sequence("all", True, kids)
    plan = Plan(root)
    if generated:
        plan.optimise()
    said: list[str] = []
    monkeypatch.setattr("py_trees.logging.Logger.debug", lambda self, message: said.append(message))
    plan.tick()
    assert root.status is S
    assert not said
    assert board.pose.at == 7
    assert not board.exists("y")
    assert kids[1].feedback_message == "'x' comparison succeeded [v: 1][e: 1]"


def test_a_comparison_follows_what_it_compares(board: Client) -> None:
    expected = [1]
    leaf = behaviours.CheckBlackboardVariableValue("check", ComparisonExpression("x", lambda: expected[0], operator.eq))
    plan = hot(composites.Sequence("s", True, [leaf]))
    for x, wanted, status in ((1, 1, S), (2, 1, F), (2, 2, S), (2.0, 2, S)):
        board.x, expected[0] = x, wanted
        plan.tick()
        word = "succeeded" if status is S else "failed"
        assert (leaf.status, leaf.feedback_message) == (status, f"'x' comparison {word} [v: {x}][e: {wanted}]")
    leaf.check = ComparisonExpression("x", 3, operator.lt)
    plan.tick()
    assert leaf.feedback_message == "'x' comparison succeeded [v: 2.0][e: 3]"


def test_the_text_of_what_may_change_is_made_at_each_tick(board: Client) -> None:
    board.x = grown = [1]
    leaf = checking([1, 2], operator.ne)
    plan = hot(composites.Sequence("s", True, [leaf]))
    plan.tick()
    grown.append(3)
    plan.tick()
    assert leaf.feedback_message == "'x' comparison succeeded [v: [1, 3]][e: [1, 2]]"


def test_a_variable_named_like_an_attribute_of_clients_is_read_as_py_trees_reads_it(board: Client) -> None:
    board.set("name", 5)
    theirs, ours = checking(5, key="name"), checking(5, key="name")
    theirs.tick_once()
    hot(ours).tick()
    name = "check"  # of the client, which `get` finds before the variable
    assert theirs.feedback_message == ours.feedback_message == f"'name' comparison failed [v: {name}][e: 5]"


def test_an_activity_stream_hears_of_every_reading(board: Client) -> None:
    board.x = 1
    plan = hot(checking(1))
    plan.tick()
    Blackboard.enable_activity_stream()
    plan.tick()
    assert [item.key for item in Blackboard.activity_stream.data] == ["/x"]


def test_a_right_that_was_withdrawn_is_missed(board: Client) -> None:
    board.x = 1
    leaf = checking(1)
    plan = hot(leaf)
    plan.tick()
    leaf.blackboard.unregister_key("x", clear=False)
    with pytest.raises(AttributeError, match="does not have read/write access to '/x'"):
        plan.tick()


@pytest.mark.parametrize("on", ["instance", "class"])
@pytest.mark.parametrize("generated", [False, True])
def test_a_replaced_update_is_called_from_the_next_tick_on(
    on: str, generated: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    leaf = behaviours.Success("leaf")
    plan = Plan(composites.Sequence("s", True, [leaf]))
    if generated:
        plan.optimise()
    plan.tick()
    if on == "instance":
        leaf.update = lambda: F  # type: ignore[method-assign]
    else:
        monkeypatch.setattr(behaviours.Success, "update", lambda self: F)
    plan.tick()
    assert leaf.status is F


def test_an_update_that_another_one_calls_is_watched_too(board: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    board.x = 1
    leaf = behaviours.WaitForBlackboardVariableValue("wait", ComparisonExpression("x", 1, operator.eq))
    plan = hot(leaf)
    plan.tick()
    assert leaf.status is S
    monkeypatch.setattr(behaviours.CheckBlackboardVariableValue, "update", lambda self: F)
    plan.tick()
    assert leaf.status is R


def test_nothing_is_compared_twice_when_a_trace_ends(board: Client) -> None:
    board.x = 1
    looked: list[int] = []

    def equal(value: int, expected: int) -> bool:
        looked.append(value)
        return value == expected

    last = checking(1, equal)
    root = composites.Sequence("s", False, [checking(1, equal), decorators.SuccessIsRunning("on", last)])
    plan = Plan(root)
    for _ in range(9):
        plan.tick()
    assert plan._trace is not None
    board.x = 2
    looked.clear()
    plan.tick()
    assert looked == [2]
    board.x = 1
    looked.clear()
    plan.tick()
    assert looked == [1, 1]
    assert root.status is R


class Looked:
    """A value that counts how often it is looked into, and has nothing there at times."""

    def __init__(self) -> None:
        self.looks, self.lacking = 0, False

    def __str__(self) -> str:
        return "looked"

    @property
    def at(self) -> Any:
        self.looks += 1
        if self.lacking:
            raise AttributeError("at")
        return Status.SUCCESS if self.looks % 2 else 3


NESTED: dict[str, Callable[[], Any]] = {
    "exists": lambda: behaviours.CheckBlackboardVariableExists("leaf", "x.at"),
    "waits": lambda: behaviours.WaitForBlackboardVariable("leaf", "x.at"),
    "status": lambda: behaviours.BlackboardToStatus("leaf", "x.at"),
    "sets": lambda: behaviours.SetBlackboardVariable("leaf", "x.at", 5, True),
    "compares": lambda: behaviours.CompareBlackboardVariables("leaf", "x", "y", operator.is_),
    "unsets": lambda: behaviours.UnsetBlackboardVariable("leaf", "x"),
    "checks": lambda: behaviours.CheckBlackboardVariableValues(
        "leaf", [ComparisonExpression(v, 3, operator.eq) for v in ("x.at", "y")], operator.or_, "results"
    ),
}


@pytest.mark.parametrize("kind", NESTED)
def test_what_is_nested_is_looked_at_as_often_and_ends_alike(board: Client, kind: str) -> None:
    theirs, ours = NESTED[kind](), NESTED[kind]()
    plan, rng = hot(ours), random.Random(kind)
    for _ in range(60):
        value, other, lacking = rng.random() < 0.8, rng.choice([None, 1, 3]), rng.random() < 0.3
        looks = rng.randint(0, 1)
        ends = []
        for leaf, tick in ((theirs, theirs.tick_once), (ours, plan.tick)):
            Blackboard.storage.clear()
            looked = Looked()
            looked.looks, looked.lacking = looks, lacking
            if value:
                Blackboard.storage["/x"] = looked
            if other is not None:
                Blackboard.storage["/y"] = other
            error = ""
            try:
                tick()
            except (KeyError, TypeError) as raised:
                error = f"{type(raised).__name__}: {raised}"
            stored = {key: str(kept) for key, kept in Blackboard.storage.items()}
            ends.append((leaf.status, leaf.feedback_message, looked.looks, error, stored))
        assert ends[0] == ends[1]


KINDS: dict[str, Callable[[str], Any]] = {
    "exists": lambda key: behaviours.CheckBlackboardVariableExists("leaf", key),
    "waits": lambda key: behaviours.WaitForBlackboardVariable("leaf", key),
    "check": lambda key: checking(1, key=key),
    "wait": lambda key: behaviours.WaitForBlackboardVariableValue("leaf", ComparisonExpression(key, 1, operator.eq)),
    "status": lambda key: behaviours.BlackboardToStatus("leaf", key),
    "set": lambda key: behaviours.SetBlackboardVariable("leaf", key, 7, True),
    "unset": lambda key: behaviours.UnsetBlackboardVariable("leaf", key),
    "two": lambda key: behaviours.CompareBlackboardVariables("leaf", key, "pose", operator.eq),
    "all": lambda key: behaviours.CheckBlackboardVariableValues(
        "leaf", [ComparisonExpression(name, 1, operator.eq) for name in (key, "pose")], operator.or_
    ),
}


def stored(kind: str) -> dict[str, Any]:
    """Return other values at each place, so that who looks at the wrong one is seen."""
    return {"/x": R, "/y": S, "/pose": 1} if kind == "status" else {"/x": 1, "/y": 2, "/pose": 1}


def left(leaf: Any, tick: Callable[[], None], kind: str) -> tuple[Any, ...]:
    """Tick once over a fresh blackboard; return all that can be seen afterwards."""
    Blackboard.storage.clear()
    Blackboard.storage.update(stored(kind))
    stream = Blackboard.activity_stream
    if stream is not None:
        stream.clear()
    tick()
    said = [(item.key, item.activity_type, item.current_value) for item in stream.data] if stream is not None else []
    return leaf.status, leaf.feedback_message, said, dict(Blackboard.storage)


@pytest.mark.parametrize("kind", KINDS)
def test_an_activity_stream_hears_of_every_leaf_what_py_trees_tells_it(board: Client, kind: str) -> None:
    theirs, ours = KINDS[kind]("x"), KINDS[kind]("x")
    plan = hot(ours)
    left(ours, plan.tick, kind)
    Blackboard.enable_activity_stream()
    told = left(theirs, theirs.tick_once, kind)
    assert told[2], "there is something to hear"
    assert left(ours, plan.tick, kind) == told


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_changed_about_a_leaf_counts_from_the_next_tick_on(board: Client, kind: str) -> None:
    """Whatever attribute of the leaf it is: each is taken from a leaf over another variable, by itself."""
    names = vars(KINDS[kind]("x")).keys() & {
        *("key", "variable_name", "variable_value_generator", "overwrite", "check", "checks", "operator"),
        *("var1_key", "var2_key", "blackboard"),
    }
    assert names
    for name in sorted(names):
        ends = []
        for planned in (False, True):
            leaf, other = KINDS[kind]("x"), KINDS[kind]("y")
            for each in (leaf, other):
                for key in ("x", "y", "pose"):
                    each.blackboard.register_key(key=key, access=Access.WRITE)
                    each.blackboard.register_key(key=key, access=Access.READ)
            plan = hot(leaf)
            tick = plan.tick if planned else leaf.tick_once
            left(leaf, tick, kind)
            setattr(leaf, name, False if name == "overwrite" else getattr(other, name))
            ends.append(left(leaf, tick, kind))
        assert ends[0] == ends[1], name
