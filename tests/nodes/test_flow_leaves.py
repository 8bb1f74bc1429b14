import pytest

from grip_bt.base.errors import DataError


def test_wait_ends_when_the_clock_says_so_and_asks_to_be_woken_then(world, tick):
    leaf = world.leaf("flow/wait", seconds=2.5)
    assert tick(leaf)[0] == "RUNNING"
    assert world.context.alarms == [102.5]
    world.context.time = 102.4
    assert tick(leaf)[0] == "RUNNING"
    world.context.time = 102.5
    assert tick(leaf) == ("SUCCESS", "success", None)


def test_each_activation_waits_its_own_time(world, tick):
    leaf = world.leaf("flow/wait", seconds=1.0)
    tick(leaf)
    world.context.time = 101.0
    tick(leaf)
    assert tick(leaf)[0] == "RUNNING"
    assert world.context.alarms == [101.0, 102.0]


def test_waiting_no_time_succeeds_at_once(world, tick):
    assert tick(world.leaf("flow/wait", seconds=0.0))[0] == "SUCCESS"


def test_succeed_succeeds(world, tick):
    assert tick(world.leaf("flow/succeed")) == ("SUCCESS", "success", None)


def test_fail_fails_with_the_reason_of_the_task(world, tick):
    leaf = world.leaf("flow/fail", code="too_dark", message="switch the light on")
    assert tick(leaf) == ("FAILURE", "failure", "too_dark")
    assert str(leaf.failure) == "too_dark: switch the light on"


def test_log_tells_the_observer_the_sentence_and_the_value(world, tick):
    told = []
    leaf = world.leaf("flow/log", message="seen", value=3)
    leaf.observer = type("Listener", (type(leaf.observer),), {"message": lambda self, *what: told.append(what)})()
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert told == [("task/leaf", "seen: 3")]


def written_by(leaf):
    values = []
    leaf.writers["value"] = values.append
    return values


def test_set_writes_its_literal_and_a_later_change_of_it_is_not_seen(world, tick):
    leaf = world.leaf("flow/set", value=[1, 2])
    written = written_by(leaf)
    assert tick(leaf) == ("SUCCESS", "success", None)
    written[0].append(3)
    tick(leaf)
    assert written == [[1, 2, 3], [1, 2]]


def test_compute_writes_what_its_expression_comes_to(world, tick):
    leaf = world.leaf("flow/compute", expression="a * b + 1", a=3, b=2)
    written = written_by(leaf)
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert written == [7]


def test_compute_refuses_a_name_that_no_variable_is_bound_to(world):
    with pytest.raises(DataError, match="the expression names it, and no variable is bound"):
        world.leaf("flow/compute", expression="a + b", a=3)
