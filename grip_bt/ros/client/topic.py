"""Topics: messages waited for, looked at and published, with the settings of whoever is at the other end.

A subscription that asks for more than a publisher offers (reliable from best-effort, the past from volatile) is never
connected, and nobody is told. So a reader looks for publishers first, subscribes with what all of them offer, and says
who publishes what when nothing comes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rclpy.qos import DurabilityPolicy, QoSCompatibility, QoSProfile, ReliabilityPolicy, qos_check_compatible

from grip_bt.base.errors import GripError, plural
from grip_bt.base.failures import CanceledError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.task.catalog.component_file import Qos

from .base import Client, Request
from .connection import Connection
from .graph import instead
from .types import InterfaceType, Message, load_type, type_name

RELOOK = 0.5
"""How often a reader in use looks whether its publishers changed [s]."""


@dataclass(frozen=True)
class Received:
    """A message and when it came, on this process's steady clock [s]."""

    message: Message
    time: float


@dataclass(eq=False)
class _Message(Request):
    subscribers: int = 0  # how many are needed


class TopicReader(Client[Request]):
    """The one subscription of a topic in this process; made by `Bus.reader`.

    Attributes:
        type: the message's class; None until a publisher is seen, where nobody has said which.
        latest: the last message, None before the first.
    """

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        super().__init__(bus, type_, name)
        self.latest: Received | None = None
        self._profile: QoSProfile | None = None
        self._listeners: list[Callable[[Received], None]] = []
        self._looked = float("-inf")
        self._listening = False

    # --- from any thread ---

    def listen(self, callback: Callable[[Received], None] | None = None) -> Operation[None]:
        """Subscribe, so that `latest` is kept; `callback` is called on the bus's thread with each message."""

        def start() -> None:
            if callback is not None:
                self._listeners.append(callback)
            self._listening = True
            self._look(time.monotonic())
            self._bus.watch()

        return self._bus.post(start)

    def ignore(self, callback: Callable[[Received], None]) -> None:
        def stop() -> None:
            if callback in self._listeners:
                self._listeners.remove(callback)

        self._bus.post(stop)

    def next(self, timeout: float | None = None) -> Operation[Message]:
        """Wait for the next message that comes from now on.

        Ends with ServerTimeOutError, which tells who publishes the topic, after `timeout` [s].
        """
        now = time.monotonic()
        return self._begin(Request(None, now, now + (self._bus.wait if timeout is None else timeout)))

    def recent(self, max_age: float, timeout: float | None = None) -> Operation[Message]:
        """Return the last message when it is at most `max_age` [s] old, else wait for the next."""
        latest = self.latest
        if latest is not None and time.monotonic() - latest.time <= max_age:
            return Operation.finished(latest.message)
        return self.next(timeout)

    # --- on the bus's thread ---

    def poll(self) -> bool:
        """Look at who waits; False when nobody does."""
        now = time.monotonic()
        if (self._requests and self._made is None) or now - self._looked > RELOOK:
            self._look(now)
        for wait in [w for w in self._requests if now > w.deadline]:
            text = f"{self.name}: no message within {wait.deadline - wait.began:.1f} s; {self.publishers()}"
            self._finish(wait, ServerTimeOutError(text, topic=self.name))
        return bool(self._requests) or (self._listening and self._made is None)

    def _submit(self, request: Request) -> None:
        self._requests.append(request)
        self._look(time.monotonic())
        self._bus.watch()

    def publishers(self) -> str:
        """Say who publishes the topic, and whether we could hear it, else which topics there are instead of it."""
        found = self._bus.node.get_publishers_info_by_topic(self.name)
        wanted = "" if self.type is None else type_name(self.type)
        if not found:
            return f"it has no publisher{instead(self._bus.node, self.name, wanted, 'published')}"
        types = sorted({p.topic_type for p in found})
        if not wanted:
            return f"it is published as {' and as '.join(types)}; specify the message type to subscribe with"
        wrong, right = [t for t in types if t != wanted], sum(p.topic_type == wanted for p in found)
        if not right:
            said = f"it is published as {', '.join(wrong)}, not as {wanted}; name that type, or another topic"
            return said + instead(self._bus.node, self.name, wanted, "published")
        others = f"; others publish it as {', '.join(wrong)}" if wrong else ""
        why = _misfit((p.qos_profile, self._profile or p.qos_profile) for p in found if p.topic_type == wanted)
        return f"{plural(right, 'publisher')}, but no message arrived{why}{others}"

    def _look(self, now: float) -> None:
        """Subscribe with what the publishers offer; again when that changes."""
        self._looked = now
        found = self._bus.node.get_publishers_info_by_topic(self.name)
        if self.type is None and not self._adopt({p.topic_type for p in found}):
            return
        mine = [p.qos_profile for p in found if p.topic_type == type_name(self.type)]
        reliable = bool(mine) and all(q.reliability == ReliabilityPolicy.RELIABLE for q in mine)
        lasting = bool(mine) and all(q.durability == DurabilityPolicy.TRANSIENT_LOCAL for q in mine)
        profile = _profile(self.qos, reliable, lasting)
        if not mine or (self._made is not None and self._profile == profile):
            return  # also for a publisher of another type: a subscription would spoil the name for this process
        if self._made is not None:
            self._bus.node.destroy_subscription(self._made)
        self._profile = profile
        self._made = self._bus.node.create_subscription(self.type, self.name, self._received, profile)

    def _adopt(self, published: set[str]) -> bool:
        """Take the one type that the topic is published as; False while there is none, or more than one."""
        if len(published) != 1:
            return False
        try:
            self.type = load_type(*published)
        except GripError as error:
            self.end(error)
        return self.type is not None

    def _received(self, message: Message) -> None:
        self.latest = received = Received(message, time.monotonic())
        waits, self._requests = self._requests, []
        for wait in waits:
            wait.operation.succeed(message)
        for listener in list(self._listeners):
            listener(received)


class TopicWriter(Client[_Message]):
    """The one publisher of a topic in this process; made by `Bus.writer`. Reliable, and keeps the last messages."""

    def advertise(self) -> None:
        """Be there before anything is published, so that subscribers find it.

        Raises:
            GripError: the connection was closed.
        """
        self._bus.ask(self._make)

    def listeners(self) -> int:
        """Return how many subscribers there are; none after the connection was closed."""
        try:
            return self._bus.ask(lambda: 0 if self._made is None else self._made.get_subscription_count())
        except CanceledError:
            return 0

    def _make(self) -> None:
        if self._made is None:
            self._made = self._bus.node.create_publisher(self.type, self.name, _profile(self.qos, True, False))

    def publish(self, message: Message, subscribers: int = 0, timeout: float | None = None) -> Operation[None]:
        """Publish a message, when at least `subscribers` listen.

        Ends with ServerTimeOutError when they don't come within `timeout` [s].
        """
        now = time.monotonic()
        deadline = now + (self._bus.wait if timeout is None else timeout)
        return self._begin(_Message(message, now, deadline, subscribers=subscribers))

    def _submit(self, request: _Message) -> None:
        self._make()
        self._requests.append(request)
        self._bus.watch()
        self.poll()

    def poll(self) -> bool:
        """Publish what can be; False when nothing waits."""
        now = time.monotonic()
        for wait in list(self._requests):
            there = self._made.get_subscription_count()
            if there >= wait.subscribers:
                self._publish(wait)
            elif now > wait.deadline:
                waited = wait.deadline - wait.began
                text = f"{self.name}: {there} subscribers after {waited:.1f} s, {wait.subscribers} are needed"
                text += "" if there else self._subscribers()
                self._finish(wait, ServerTimeOutError(text, topic=self.name))
        return bool(self._requests)

    def _publish(self, wait: _Message) -> None:
        try:
            self._made.publish(wait.message)
        except Exception as error:  # noqa: BLE001 - rclpy's TypeErrors of a wrong message
            self._finish(wait, error)
        else:
            self._finish(wait)

    def _subscribers(self) -> str:
        """Say what is heard instead, where nobody hears this."""
        wanted, found = type_name(self.type), self._bus.node.get_subscriptions_info_by_topic(self.name)
        wrong = sorted({end.topic_type for end in found if end.topic_type != wanted})
        said = f"; it is subscribed to as {', '.join(wrong)}, not as {wanted}" if wrong else ""
        ours = _profile(self.qos, True, False)
        said += _misfit((ours, end.qos_profile) for end in found if end.topic_type == wanted)
        return said + instead(self._bus.node, self.name, wanted, "heard")


def _profile(qos: Qos, reliable: bool, lasting: bool) -> QoSProfile:
    """Return what is asked for, where nothing is asked for what is given."""
    reliable = qos.reliability == "reliable" if qos.reliability else reliable
    lasting = qos.durability == "transient_local" if qos.durability else lasting
    return QoSProfile(
        depth=qos.depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if lasting else DurabilityPolicy.VOLATILE,
    )


def _misfit(pairs: Iterable[tuple[QoSProfile, QoSProfile]]) -> str:
    """Say why publishers and subscribers of these qualities of service never connect; empty where they do."""
    checked = (qos_check_compatible(*pair) for pair in pairs)
    said = [reason.strip("; ") for found, reason in checked if found == QoSCompatibility.ERROR]
    return f"; `qos`: {said[0]}" if said else ""
