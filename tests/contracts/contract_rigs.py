"""What a contract is tested with.

A rig holds an adapter and the means to let its time pass: `wait(operation)` until it ends, `let_pass(seconds)`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from patience import PATIENCE

from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Executor, Hand, HandPort
from grip_bt.base.values import JointState
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.commanders.trajectory.stopping import ACCELERATION

PATIENT = PlanningSettings(planning_time=PATIENCE)
"""A plan may take what a slow machine needs."""


@dataclass
class Rig:
    """An adapter and its time.

    Attributes:
        port: the adapter.
        let_pass: lets seconds pass.
        exact: whether no time passes but by `let_pass`, so that nobody is ever late.
        braking: how hard its joints may brake, a number for all or shape (n,) [rad/s^2 or m/s^2].
    """

    port: Any
    let_pass: Callable[[float], None]
    exact: bool = field(default=False, kw_only=True)
    braking: Any = field(default=ACCELERATION, kw_only=True)

    def wait(self, operation: Operation[Any], at_most: float = PATIENCE) -> Operation[Any]:
        """Let time pass until the operation ends."""
        waited = 0.0
        while not operation.done() and waited < at_most:
            self.let_pass(0.05)
            waited += 0.05
        assert operation.done(), f"not ended after {at_most} s"
        return operation


@dataclass
class ExecutorRig(Rig):
    port: Executor
    goal: JointState
    """Joint positions that can be reached freely, half a radian or so away."""
    spoil: Callable[[], None] | None = None
    """Has the next motion towards `goal` be given up half-way; it may change the goal for that. None: nothing can."""
    ends: tuple[JointState, JointState] = field(init=False)
    """Of the way to and fro that is free: where it begins, and the goal."""

    def __post_init__(self) -> None:
        self.ends = self.port.state(), self.goal


@dataclass
class HandRig(Rig):
    port: HandPort | Hand
    open: JointState
    closed: JointState
    offer: Callable[[], None]
    """Puts a thing between the fingers."""
    take: Callable[[], None] | None = None
    """Takes it away again. None: the fingers stay where they were stopped then, and nothing in the hand can tell."""
    slow_down: Callable[[], None] = lambda: None
    """Makes motions slow where a duration doesn't, as with a gripper that has its own speed."""
    regulates: bool = True
    """Whether it can press with a force that it is told."""


@dataclass
class ArmRig(Rig):
    port: Arm
    away: JointState
    """A free goal other than `home`."""
    offset: np.ndarray
    """A way [m] that the grasp frame can go straight from `home`."""


@dataclass
class Patient:
    """A planning service whose operations have ended when it returns them: planning takes no time on the clock."""

    service: Any

    def submit(self, request: Any) -> Operation[Any]:
        operation = self.service.submit(request)
        assert operation.wait(PATIENCE)
        return operation
