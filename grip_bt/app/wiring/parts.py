"""What a run waits for while it starts, told to whoever looks at it: silence looks like a fault."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Camera, Clock, Component, Hand, Messages, Pausable, Ros, Scene, Sensor
from grip_bt.base.values import JointState

if TYPE_CHECKING:
    from grip_bt.runtime import RunContext
    from grip_bt.runtime.lockstep import Lockstep

    from .fake import FakeState

SOON = 1.5
"""What takes no longer needs no words [s]."""


@contextmanager
def told_when_slow(progress: Progress, part: str, words: Callable[[], str], after: float = SOON) -> Iterator[None]:
    """Say what is waited for, once, where that takes its time; nothing is said after the end.

    Args:
        progress: told `(part, words)`, from another thread.
        part: which part of the run waits.
        words: asked what to say, when it is said.
        after: how long to be silent [s].
    """
    timer = threading.Timer(after, lambda: progress(part, words()))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()


Progress = Callable[[str, str], None]
"""Told `(part, detail)` as parts come up."""


def silent(part: str, detail: str) -> None:
    """Say nothing."""


@dataclass
class Resources:
    """The parts that a run offers to its leaves; and the referee, simulated world and fakes, which it doesn't."""

    clock: Clock | None = None
    arms: Mapping[str, Arm] = field(default_factory=dict)
    hands: Mapping[str, Hand] = field(default_factory=dict)
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    components: Mapping[str, Component] = field(default_factory=dict)
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    ros: Ros | None = None
    messages: Messages | None = None
    scene: Scene | None = None
    referee: Any = None
    world: Any = None
    fakes: FakeState | None = None
    pausable: Sequence[Pausable] = ()
    lockstep: Lockstep | None = None
    measure: Callable[[Sequence[str]], Operation[JointState]] | None = None

    def context(self, clock: Clock | None = None) -> RunContext:
        """Return what a run gives to its leaves; `clock` in place of the parts' own."""
        from grip_bt.runtime import RunContext

        return RunContext(
            clock or self.clock,
            arms=self.arms,
            hands=self.hands,
            cameras=self.cameras,
            components=self.components,
            scene=self.scene,
            sensors=self.sensors,
            ros=self.ros,
            messages=self.messages,
            pausable=self.pausable,
            lockstep=self.lockstep,
            measure=self.measure,
        )


RobotKind = Literal["sim", "fake", "ros"]
