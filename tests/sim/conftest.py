"""What the tests of running simulations share."""

from __future__ import annotations

import pytest
from sim_bench import SPEC, Bench

from grip_sim.simulation import start_simulation


@pytest.fixture(scope="module")
def shared_simulation():
    with start_simulation(SPEC) as simulation:
        yield simulation


@pytest.fixture
def bench(shared_simulation):
    made = Bench(shared_simulation)
    made.reset()
    return made
