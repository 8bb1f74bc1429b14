"""What every executor promises of a stop: a ramp to rest before the goal, and an end that comes only with that.

How long it took is judged here where time is exact; where it is the wall's, `benchmarks/stopping.py` measures it.
"""

from __future__ import annotations

import numpy as np
import pytest
from on_the_way import SLOW
from stopping import AT_REST, BEYOND, Stopped, go_elsewhere, smooth, stopped

from grip_bt.base.failures import CanceledError

SECONDS = 2.0
MOMENTS = np.random.default_rng(13).uniform(0.0, 0.9, 40) * SECONDS


def check(made: Stopped, rig, way: str) -> None:
    if way != "pause":
        assert isinstance(made.error, CanceledError)
        assert made.error.data.get("stopped", True), made.error.message
        assert made.ended is not None
        after = made.positions[made.times >= made.ended]
        assert len(after)
        assert np.ptp(after, axis=0).max() < 4e-3, "it was over before the joints were at rest"
    if rig.exact:
        assert made.beyond(rig.braking) < BEYOND
        assert made.hardest(rig.braking) < 1.1, "it is a ramp"
        assert np.abs(made.velocities[made.times >= made.rest]).max() <= AT_REST


@pytest.mark.parametrize("way", ["cancel", "stop"])
def test_a_stop_at_any_moment_is_a_ramp_and_ends_at_rest(executor_rig, way):
    rig = executor_rig
    for moment in MOMENTS[: 8 if rig.exact else 1]:
        made = stopped(rig, lambda: rig.port.execute(smooth(rig, SECONDS if rig.exact else SLOW)), moment, way)
        check(made, rig, way)
        if not rig.exact or moment < SECONDS / 2:
            assert np.abs(made.positions[-1] - rig.goal.ordered(rig.port.joint_names)).max() > 0.05
        go_elsewhere(rig)


def test_a_pause_at_any_moment_is_a_ramp(pausable_rig):
    rig = pausable_rig
    for moment in MOMENTS[: 8 if rig.exact else 1]:
        made = stopped(rig, lambda: rig.port.execute(smooth(rig, SECONDS if rig.exact else SLOW)), moment, "pause")
        check(made, rig, "pause")
        go_elsewhere(rig)


@pytest.mark.parametrize("way", ["cancel", "stop"])
def test_fingers_that_are_stopped_come_to_rest_before_the_motion_ends(hand_port_rig, way):
    rig = hand_port_rig
    if not rig.exact:
        rig.slow_down()
    for moment in (0.1, 0.3, 0.45)[: 3 if rig.exact else 1]:
        made = stopped(rig, lambda: rig.port.move(rig.closed, 1.0 if rig.exact else SLOW), moment, way)
        check(made, rig, way)
        rig.wait(rig.port.move(rig.open, 1.0))
