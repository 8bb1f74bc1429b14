"""What a contract is tested with.

A rig holds an adapter and the means to let its time pass: `wait(operation)` until it ends, `let_pass(seconds)`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from grip_bt.operation import Operation
from grip_bt.ports import Arm, Executor, Hand, HandPort
from grip_bt.values import JointState


@dataclass
class Rig:
    """An adapter and its time.

    Attributes:
        port: the adapter.
        let_pass: lets seconds pass.
    """

    port: Any
    let_pass: Callable[[float], None]

    def wait(self, operation: Operation[Any], at_most: float = 30.0) -> Operation[Any]:
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


@dataclass
class HandRig(Rig):
    port: HandPort | Hand
    open: JointState
    closed: JointState
    offer: Callable[[], None]
    """Puts a thing between the fingers."""


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
        assert operation.wait(60)
        return operation
