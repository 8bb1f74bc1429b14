"""What the executors over ROS have in common: one motion at a time, begun where the joints are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grip_bt.errors import ExecutionAbortedError, SensorError
from grip_bt.operation import Operation
from grip_bt.values import JointState, Trajectory

from .joint_states import JointStates

START_TOLERANCE = 0.05
"""A trajectory begins within this distance of where the joints are [rad or m]."""


def check_start(names: Sequence[str], trajectory: Trajectory, states: JointStates) -> None:
    """Refuse a trajectory of other joints, or one that begins elsewhere.

    Raises:
        ValueError: it moves other joints.
        ExecutionAbortedError: it begins further than 0.05 from the joints, or nothing is known of them.
    """
    if set(trajectory.names) != set(names):
        raise ValueError(f"the trajectory moves {trajectory.names}, this executor {tuple(names)}")
    try:
        measured = states.state(trajectory.names).position
    except SensorError as error:
        raise ExecutionAbortedError(error.message, cause=error.code) from None
    errors = np.abs(trajectory.positions[0] - measured)
    if errors.max() > START_TOLERANCE:
        worst = int(errors.argmax())
        raise ExecutionAbortedError(
            f"the trajectory begins {errors[worst]:.3f} away from joint {trajectory.names[worst]}",
            error=float(errors[worst]),
        )


def measured(states: JointStates, names: Sequence[str]) -> Operation[JointState]:
    """Return what is measured from now on; ends with ExecutionAbortedError when nothing is."""
    whole: Operation[JointState] = Operation()
    fresh = states.fresh(names)

    def end() -> None:
        try:
            whole.succeed(fresh.result())
        except SensorError as error:
            whole.fail(ExecutionAbortedError(f"the motion ended, but {error.message}", cause=error.code))

    fresh.add_done_callback(end)
    return whole
