"""What a run is made of, as values, and the protocol of those who provide a robot."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal

from grip_bt.app.project.folder import Project
from grip_bt.app.wiring.equipment import Equipment
from grip_bt.base.errors import MissingPartError, libraries_of
from grip_bt.base.ports import Clock
from grip_bt.commanders.fake import FakeArm, FakeComponent, FakeHand
from grip_bt.commanders.taught import TaughtStates
from grip_bt.runtime import RunContext, RunParts
from grip_sim.faults import Fault
from grip_sim.simulation import SimReferee, Simulation

Progress = Callable[[str, str], None]
"""Told `(part, detail)` as parts come up."""
SOON = 1.5
"""What takes no longer isn't reported [s]."""


def silent(part: str, detail: str) -> None:
    """Say nothing."""


@contextmanager
def report_if_slow(progress: Progress, part: str, words: Callable[[], str], after: float = SOON) -> Iterator[None]:
    """Say what is waited for, once, where that takes its time; nothing is said after the end.

    Args:
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


RobotKind = Literal["sim", "fake", "ros"]


def load_part(module: str, what: str, extra: str) -> Any:
    """Import a module of this package that needs an extra of the installation.

    Raises:
        MissingPartError: it isn't installed.
    """
    try:
        return import_module(f"{__package__}.{module}")
    except ImportError as error:
        how = libraries_of(str(error)) or f"pip install 'grip-bt[{extra}]'"
        how += ", or do without: --robot fake" if extra == "sim" else ""
        raise MissingPartError(f"{what} ({error})", how) from None


@dataclass
class FakeState:
    """Where fake arms and hands are, what was taught to them, and which reply of a component is the next."""

    arms: Mapping[str, FakeArm] = field(default_factory=dict)
    hands: Mapping[str, FakeHand] = field(default_factory=dict)
    components: Mapping[str, FakeComponent] = field(default_factory=dict)
    taught: TaughtStates = field(default_factory=TaughtStates)

    def kept(self) -> dict[str, Any]:
        """Return all of it, as a value of the journal."""
        return {
            "arms": {name: arm.state().position for name, arm in self.arms.items()},
            "hands": {name: hand.kept() for name, hand in self.hands.items()},
            "components": {name: component.given for name, component in self.components.items()},
            "taught": {part: dict(self.taught.of(part)) for part in self.taught.parts()},
        }

    def put_back(self, kept: Mapping[str, Any]) -> None:
        """Have everything as it was; nothing may be under way.

        Raises:
            KeyError, ValueError: an arm, a hand or a component isn't here any more, or has other joints.
        """
        for parts, states in ((self.arms, kept["arms"]), (self.hands, kept["hands"])):
            for name, position in states.items():
                parts[name].put_back(position)
        for name, given in kept["components"].items():
            self.components[name].put_back(given)
        for part, entries in kept["taught"].items():
            for name, value in entries.items():
                self.taught.put(part, name, value, {})


@dataclass(frozen=True)
class Resources(RunParts):
    """The parts that a run offers to its leaves; and its clock, simulated world and fakes, which it doesn't.

    Attributes:
        clock: of the run, where a part has one of its own.
    """

    clock: Clock | None = None
    world: Simulation | None = None
    fakes: FakeState | None = None

    @property
    def referee(self) -> SimReferee | None:
        """Who knows the truth of the simulated world."""
        return None if self.world is None else self.world.referee

    def context(self, clock: Clock | None = None) -> RunContext:
        """Return what a run gives to its leaves; `clock` in place of the parts' own."""
        return RunContext(clock or self.clock, self)


@dataclass(frozen=True)
class Opening:
    """With what a robot is started.

    Attributes:
        project: whose robot, arms, hands and sensors.
        seed: of the simulated world, and of the planners.
        pace: simulated seconds per second; None for as fast as it goes.
        progress: told of each part that came up.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.
        faults: what goes wrong in the simulated world besides its own faults; None for nothing at all.
        object: of the library or a file; every object of the simulated world is one, where it isn't empty.
        apart: whether a DDS domain of its own is a free one, whatever ROS_DOMAIN_ID says.
        equipment: what earlier runs of this process have left.
    """

    project: Project
    seed: int = 0
    pace: float | None = None
    progress: Progress = silent
    hold: int | None = None
    faults: Mapping[str, Fault] | None = field(default_factory=dict)
    object: str = ""
    apart: bool = False
    equipment: Equipment = field(default_factory=Equipment)


OpenRobot = Callable[[Opening, ExitStack], Resources]
"""Starts a project's robot, which the stack closes: arms, hands, cameras and planning scene.

What a project names is verified before anything is started for it. GripError says what isn't there, can't be read, or
doesn't come up.
"""
