"""Waiting for a condition costs nothing between two looks, and can be given up."""

from __future__ import annotations

import pytest
from py_trees.common import Status


@pytest.fixture
def waiting(world):
    """Return a leaf that waits, and the list of the values of `a` that it has read."""
    looks = []
    leaf = world.leaf("flow/wait_until", expression="a > 3", timeout=5.0, a=1)
    leaf.readers["a"] = lambda: looks.append(1) or 1
    leaf.tick_once()
    return leaf, looks


def test_a_tick_looks_once_and_returns(waiting):
    """The first GRIP looked in a busy loop on the wall's clock (its fault B43)."""
    leaf, looks = waiting
    assert (leaf.status, len(looks)) == (Status.RUNNING, 1)
    leaf.tick_once()
    assert (leaf.status, len(looks)) == (Status.RUNNING, 2)


def test_it_asks_the_runs_clock_to_be_woken_when_the_time_is_over(world, waiting):
    assert world.context.alarms == [world.context.time + 5.0]


def test_it_is_stopped_in_the_middle_and_looks_no_more(waiting):
    leaf, looks = waiting
    leaf.stop(Status.INVALID)
    assert (leaf.status, leaf.outcome, len(looks)) == (Status.INVALID, None, 1)
