"""The clock over the simulator: simulated time while something moves, ours while nothing does."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.ports import Clock
from grip_sim import client as clock_module
from grip_sim.client import SimClock


class Wall:
    """Stands for `time` in the clock's module."""

    def __init__(self):
        self.now = 100.0

    def monotonic(self):
        return self.now


@pytest.fixture
def wall(monkeypatch):
    made = Wall()
    monkeypatch.setattr(clock_module, "time", made)
    return made


STEPS = st.lists(
    st.tuples(st.sampled_from(["begin", "end", "told", "passes"]), st.floats(0, 10, allow_subnormal=False)), max_size=40
)


@given(STEPS)
@settings(deadline=None)
def test_it_never_decreases_and_is_the_sum_of_idle_and_simulated_time(steps):
    wall = Wall()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(clock_module, "time", wall)
        clock = SimClock()
        moving, idle, simulated, last = 0, 0.0, 0.0, 0.0
        for what, amount in steps:
            if what == "begin":
                clock.count(1)
                moving += 1
            elif what == "end" and moving:
                clock.count(-1)
                moving -= 1
            elif what == "told":
                clock.told(amount)
                simulated = max(simulated, amount)
            elif what == "passes":
                wall.now += amount
                idle += 0.0 if moving else amount
            now = clock.now()
            assert now >= last
            assert now == pytest.approx(idle + simulated, abs=1e-6)
            assert clock.simulated == simulated
            last = now


def test_it_satisfies_the_protocol():
    assert isinstance(SimClock(), Clock)


def test_it_starts_at_zero(wall):
    assert SimClock().now() == 0


def test_our_time_does_not_count_while_something_moves(wall):
    clock = SimClock()
    clock.count(1)
    wall.now += 5
    assert clock.now() == 0
    clock.told(0.25)
    assert clock.now() == 0.25


def test_our_time_counts_again_when_the_last_motion_has_ended(wall):
    clock = SimClock()
    clock.count(1)
    clock.count(1)
    clock.count(-1)
    wall.now += 5
    assert clock.now() == 0
    clock.count(-1)
    wall.now += 2
    assert clock.now() == 2
