"""Leaves begin as py_trees' own behaviours do, with ids that cost less."""

from copy import deepcopy
from uuid import RFC_4122, UUID

from py_trees.behaviours import Success

from grip_bt.nodes.beginning import _begin, begin, next_id


def test_a_behaviour_begun_here_has_what_one_of_py_trees_has():
    made, own = Success("a"), Success("a")
    vars(made).clear()
    _begin(made, "a")
    assert vars(made).keys() == vars(own).keys()
    for name, value in vars(own).items():
        assert type(vars(made)[name]) is type(value), name
        if name not in ("id", "iterator", "logger"):
            assert vars(made)[name] == value, name
    assert vars(made.logger) == vars(own.logger)
    made.tick_once()
    own.tick_once()
    assert made.status is own.status


def test_this_py_trees_is_known():
    assert begin is _begin


def test_ids_are_uuids_and_none_comes_twice():
    ids = [next_id() for _ in range(1000)]
    assert len(set(ids)) == 1000
    one = ids[0]
    assert (one.version, one.variant) == (4, RFC_4122)
    assert one == UUID(str(one)) == deepcopy(one)
    assert hash(one) == hash(UUID(str(one)))
    assert {one: 1}[UUID(str(one))] == 1
