"""What a run offers to its leaves: its clock, waking, workers, and the robot's parts by name."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from grip_bt.base.errors import MissingPartError, UnknownNameError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import (
    Arm,
    Camera,
    Clock,
    Component,
    Executor,
    Hand,
    HandPort,
    Messages,
    Pausable,
    Ros,
    Scene,
    Sensor,
)
from grip_bt.runtime.motion_end import Measure, Motions, Moved, Rest, measured_rest

from .clock import Waker, WallClock
from .lockstep import InTurn, Lockstep
from .pending import thought_of

T = TypeVar("T")
MESSAGES = ("next", "recent", "together")
"""What waits for messages that somebody may send at any time, and isn't a call with an answer."""


@dataclass(frozen=True)
class RunParts:
    """What a run offers to its leaves.

    Attributes:
        servers: component -> gives the id of its server's process, of those that were started for the run.
        messages: the project's named values, where there are some.
        pausable: what stands still while the run is paused, besides its clock: a simulator, an arm, a hand.
        lockstep: with the simulated world with which the run takes turns, where there is one.
        measure: measures joints anew, where the last state that is known of them may be old.
    """

    arms: Mapping[str, Arm] = field(default_factory=dict)
    hands: Mapping[str, Hand] = field(default_factory=dict)
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    components: Mapping[str, Component] = field(default_factory=dict)
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    servers: Mapping[str, Callable[[], int]] = field(default_factory=dict)
    scene: Scene | None = None
    ros: Ros | None = None
    messages: Messages | None = None
    pausable: Sequence[Pausable] = ()
    lockstep: Lockstep | None = None
    measure: Measure | None = None


class RunContext:
    """Implements `grip_bt.base.ports.Context`, where its methods are described, over mappings."""

    def __init__(self, clock: Clock | None = None, parts: RunParts | None = None):
        parts = parts or RunParts()
        self.clock: Clock = clock if clock is not None else WallClock()
        self._motions = Motions()
        self.lockstep = lockstep = parts.lockstep
        parts = replace(parts, arms=self._moved(parts.arms), hands=self._moved(parts.hands))
        if lockstep is not None:
            ros = None if parts.ros is None else InTurn(parts.ros, lockstep, waiting=MESSAGES)
            thought = {name: lambda server=server: thought_of(server()) for name, server in parts.servers.items()}
            components = {n: InTurn(part, lockstep, thought.get(n, False)) for n, part in parts.components.items()}
            sensors = {name: InTurn(part, lockstep) for name, part in parts.sensors.items()}
            parts = replace(parts, components=components, sensors=sensors, ros=ros)
        self._parts = parts
        self.preempt_requests = 0
        self._pausable = [part for part in (*parts.pausable, self.clock) if isinstance(part, Pausable)]
        self._used: dict[int, Arm | Hand] = {}
        self._pausing = threading.RLock()  # a part that goes on may end what has another one let go
        self._paused = False
        self.waker = Waker(self.clock)

    @property
    def preempt_requested(self) -> bool:
        return self.preempt_requests > 0

    def request_preempt(self) -> None:
        self.preempt_requests += 1
        self.wake()

    def wake(self) -> None:
        self.waker.wake()

    def wake_at(self, time: float) -> None:
        self.waker.wake_at(time)

    def run_in_worker(self, work: Callable[[], T]) -> Operation[T]:
        return in_worker(work) if self.lockstep is None else self.lockstep.work(in_worker, work)

    def left(self, path: str, work: Operation[Any]) -> None:
        self._motions.left(path, work)

    def unfinished(self) -> Sequence[str]:
        return self._motions.unfinished()

    def arm(self, name: str) -> Arm:
        arm = _named("arm", self._parts.arms, name)
        self._used[id(arm)] = arm
        return arm

    def hand(self, name: str) -> Hand:
        hand = _named("hand", self._parts.hands, name)
        self._used[id(hand)] = hand
        return hand

    def camera(self, name: str) -> Camera:
        return _named("sensor", self._parts.cameras, name)

    def component(self, name: str) -> Component:
        return _named("component", self._parts.components, name)

    def scene(self) -> Scene:
        return _there(self._parts.scene, "a planning scene", "run with a robot: `grip run TASK --robot sim`")

    def sensor(self, name: str) -> Sensor:
        return _named("sensor", self._parts.sensors, name)

    def ros(self) -> Ros:
        return _there(self._parts.ros, "a connection to ROS", "run without `--robot fake`, and see `grip doctor`")

    def messages(self) -> Messages:
        return _there(self._parts.messages, "a store of named messages", "run the task in a project: `grip new DIR`")

    # --- for the runner ---

    def pause(self) -> None:
        """Have the clock, and whatever moves and can, stand still."""
        with self._pausing:
            self._paused = True
            for part in self._pausable:
                part.pause()

    def resume(self) -> None:
        with self._pausing:
            self._paused = False
            for part in reversed(self._pausable):
                part.resume()

    def release(self) -> None:
        """Let everything go on for the end of the run, but for motions that are held: those end where they are."""
        with self._pausing:
            for part in self._pausable:
                if self._paused and isinstance(part, (Executor, Arm, HandPort)):
                    part.stop()
            self.resume()

    def _moved(self, parts: Mapping[str, Arm | Hand]) -> dict[str, Any]:
        return {name: Moved(name, part, self._motions) for name, part in parts.items()}

    def rest(self, within: float) -> Rest:
        """Measure the arms and hands that leaves have asked for until they stand still, at most `within` [s]."""
        return measured_rest(self.moving(), self._parts.measure, within)

    def moving(self) -> list[Arm | Hand]:
        """Return the arms and hands that leaves have asked for: what has to hold when the run is stopped."""
        return list(self._used.values())


def in_worker(work: Callable[[], T]) -> Operation[T]:
    """Run `work()` in a thread of its own.

    Code can't be interrupted: when its operation is cancelled, the operation ends at once and stays `busy` until the
    code returns.
    """
    operation: Operation[T] = Operation()
    operation.busy = True

    def serve() -> None:
        try:
            result = work()
        except BaseException as error:  # noqa: BLE001 - handed to the owner, who raises it
            operation.busy = False
            operation.fail(error)
        else:
            operation.busy = False
            operation.succeed(result)

    threading.Thread(target=serve, name="grip_worker", daemon=True).start()
    return operation


_ONE = {"arm": "an arm", "hand": "a hand", "sensor": "a sensor"}
"""What a project names in its file, where a leaf wants one and there is none."""


def _there(part: T | None, what: str, how: str) -> T:
    if part is None:
        raise MissingPartError(what, how)
    return part


def _named(kind: str, parts: Mapping[str, T], name: str) -> T:
    if not name and len(parts) == 1:
        return next(iter(parts.values()))
    if not name and not parts and kind in _ONE:
        raise MissingPartError(_ONE[kind], f"name one under `{kind}s` in grip.yaml")
    if name not in parts:
        raise UnknownNameError(kind, name, parts)
    return parts[name]
