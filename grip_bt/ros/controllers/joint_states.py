"""What the joints of a robot are measured to be: the topic of joint states, whoever publishes which of them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState

from ..client.bus import Bus
from ..client.topic import Received
from ..convert_values import seconds

MESSAGE = "sensor_msgs/msg/JointState"
STALE = 1.0
"""A joint not heard of for this time [s] is unknown, unless configured otherwise."""
OURS = 1.0
"""A publisher whose stamps are no further from our date than this [s] is taken to have our clock."""
LAG_KEPT = 5.0
"""For how long the quickest message tells how a publisher's clock goes [s]."""


@dataclass(frozen=True)
class _Joint:
    position: float
    velocity: float | None
    effort: float | None
    stamp: float
    heard: float
    lag: float
    """The least that messages took lately, with what the publisher's clock is off [s]."""
    lag_since: float

    def measured_after(self, time: float, date: float) -> bool:
        """Tell whether it was measured after a time of our steady clock, not only heard: messages may have waited.

        The stamp counts on the publisher's own clock, whatever that is; where there is none, hearing it has to do. A
        publisher whose clock seems to be ours has to have measured after the date of that time too: where every message
        has waited so far, none tells how little it may take.
        """
        if self.heard <= time:
            return False
        ours = self.by_our_clock(time, date)
        return self.stamp == 0 or (self.stamp + self.lag >= time and (not ours or self.stamp >= date))

    def by_our_clock(self, time: float, date: float) -> bool:
        """Tell whether the publisher's clock seems to be ours, by the date of a time of our steady clock."""
        return abs(self.lag + date - time) < OURS


@dataclass(eq=False)
class _Wait:
    """Somebody who waits for what is measured from a moment on, until it is enough."""

    names: tuple[str, ...]
    enough: Callable[[JointState], bool]
    after: float
    date: float
    operation: Operation[bool] = field(default_factory=Operation)


class JointStates:
    """Keeps the last state of every joint.

    Args:
        stale: a joint that wasn't heard of for so long [s] isn't known any more.
    """

    def __init__(self, bus: Bus, topic: str = "/joint_states", stale: float = STALE):
        self.topic, self._stale = topic, stale
        self._lock = threading.Lock()
        self._joints: dict[str, _Joint] = {}
        self._waits: list[_Wait] = []
        self._reader = bus.reader(MESSAGE, topic)
        self._reader.listen(self._heard).wait(5.0)

    def state(self, names: Sequence[str], stale: float | None = None) -> JointState:
        """Return the last measured state of joints.

        Args:
            stale: how long ago they may have been heard of [s]; that of these joint states by default.

        Raises:
            SensorError: one of them wasn't heard of for too long; it names them and who publishes.
        """
        now, stale = time.monotonic(), self._stale if stale is None else stale
        with self._lock:
            found = [self._joints.get(name) for name in names]
        missing = [n for n, j in zip(names, found, strict=True) if j is None or now - j.heard > stale]
        if missing:
            silent = f"nothing about {', '.join(missing)} within {stale:g} s"
            raise SensorError(f"{self.topic}: {silent}; {self._reader.publishers()}", joints=missing)
        joints = [j for j in found if j is not None]
        return JointState(
            tuple(names),
            np.array([j.position for j in joints]),
            _all([j.velocity for j in joints]),
            _all([j.effort for j in joints]),
            min(j.stamp for j in joints),
        )

    def fresh(self, names: Sequence[str]) -> Operation[JointState]:
        """Return the next state of joints that is measured from now on; end with SensorError when none comes."""
        asked = time.monotonic()

        def found(measured: bool) -> Operation[JointState]:
            state = self.state(names)
            with self._lock:
                heard = all(self._joints[name].heard > asked for name in names)
            if not measured and not heard:
                raise SensorError(f"{self.topic}: no new joint states within {self._stale:g} s")
            return Operation.finished(state)

        return self.watch(names, lambda state: True, self._stale).then(found)

    def watch(self, names: Sequence[str], enough: Callable[[JointState], bool], within: float) -> Operation[bool]:
        """Show states of joints that are measured from now on until `enough` is True of one.

        Args:
            enough: called on the bus's thread; a state's time is that of its oldest stamp, or of its arrival.
            within: how long to go on [s]; the result is False when that is over.
        """
        wait = _Wait(tuple(names), enough, time.monotonic(), time.time())
        with self._lock:
            self._waits.append(wait)
        timer = threading.Timer(within, wait.operation.succeed, (False,))
        timer.daemon = True
        timer.start()
        wait.operation.add_done_callback(timer.cancel)
        return wait.operation

    def _show(self, wait: _Wait, now: float) -> None:
        """End a wait with what was measured since it began, where that is known of all of its joints."""
        with self._lock:
            known = [joint for name in wait.names if (joint := self._joints.get(name)) is not None]
        if len(known) < len(wait.names) or not all(joint.heard > wait.after for joint in known):
            return
        measured = all(joint.measured_after(wait.after, wait.date) for joint in known)
        # To have heard has to do where a clock doesn't go as ours does, a simulator's.
        late = now > wait.after + STALE and not any(joint.by_our_clock(wait.after, wait.date) for joint in known)
        if measured or late:
            state = replace(self.state(wait.names), time=min(joint.stamp or joint.heard for joint in known))
            if wait.enough(state):
                wait.operation.succeed(True)

    def wait_for(self, names: Sequence[str], within: float) -> None:
        """Block until all joints are known; for start-up. Raises SensorError: they aren't `within` [s]."""
        deadline = time.monotonic() + within
        while True:
            try:
                self.state(names)
                return
            except SensorError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.02)

    def _heard(self, received: Received) -> None:
        message, now = received.message, received.time
        stamp = seconds(message.header.stamp)
        with self._lock:
            for i, name in enumerate(message.name):
                if i < len(message.position):
                    lag, since = now - stamp, now
                    before = self._joints.get(name)
                    if before is not None and now - before.lag_since <= LAG_KEPT and lag >= before.lag:
                        lag, since = before.lag, before.lag_since
                    self._joints[name] = _Joint(
                        message.position[i],
                        message.velocity[i] if i < len(message.velocity) else None,
                        message.effort[i] if i < len(message.effort) else None,
                        stamp,
                        now,
                        lag,
                        since,
                    )
            self._waits = [wait for wait in self._waits if not wait.operation.done()]
            waits = list(self._waits)
        for wait in waits:
            self._show(wait, now)


def _all(values: list[float | None]) -> np.ndarray | None:
    known = [v for v in values if v is not None]
    return np.array(known) if len(known) == len(values) else None
