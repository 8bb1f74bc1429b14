"""ROS as leaves ask for it: topics, alone or together, frames and parameters by name, and simulated time."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from rclpy.parameter import Parameter, parameter_value_to_python

from grip_bt.base.failures import BadReplyError, ExpectedError, ServerTimeOutError
from grip_bt.base.files import Closing
from grip_bt.base.operation import Operation
from grip_bt.base.values import Pose
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.topic import Received
from grip_bt.ros.client.types import ConversionError, Message, check_name, load_message, load_type
from grip_bt.ros.convert import from_message, to_message
from grip_bt.ros.convert_values import seconds
from grip_bt.ros.transforms import Transforms

ANSWER = 2.0
"""How long a node may take to answer about a parameter once it is there [s]."""


class BadRequestError(ExpectedError):
    """A value can't be sent as the message that is asked for."""

    code = "bad_request"


class RosInterface:
    """Implements `grip_bt.base.ports.Ros` over a bus.

    Args:
        now: the time of the clock that stamps messages [s]; the wall's by default.
    """

    def __init__(self, bus: Bus, transforms: Transforms | None = None, now: Callable[[], float] = time.time):
        self.bus, self.transforms, self._now = bus, transforms or Transforms(bus), now

    def check(self, name: str, message: str = "") -> None:
        """Check a name of the graph, and that a message type is there; see `ports.Ros`."""
        check_name(name)
        if message:
            load_message(message)

    def listen(self, topic: str, message: str) -> None:
        """Subscribe now, so that a later `recent` finds what came since."""
        self.bus.reader(message, topic).listen()

    def next(self, topic: str, message: str, value: str, timeout: float) -> Operation[Any]:
        """Wait for the next message and return it as the declared type `value`; see `ports.Ros`."""
        return self.bus.reader(message, topic).next(timeout).then(lambda m: _as(topic, m, value))

    def recent(self, topic: str, message: str, value: str, max_age: float, timeout: float) -> Operation[Any]:
        """Return the last message when it is at most `max_age` [s] old, else the next."""
        return self.bus.reader(message, topic).recent(max_age, timeout).then(lambda m: _as(topic, m, value))

    def together(self, topics: Mapping[str, str], slop: float, timeout: float) -> Operation[Mapping[str, Message]]:
        """Wait for a message of each topic, taken from now on and at most `slop` [s] apart."""
        return together(self.bus, topics, slop, timeout, self._now)

    def publish(self, topic: str, message: str, value: object, subscribers: int, timeout: float) -> Operation[None]:
        """Publish a value when at least `subscribers` listen; BadRequestError when it doesn't fit the message."""
        try:
            made = to_message(value, load_type(message))
        except ConversionError as error:
            return Operation.failed(BadRequestError(f"{topic}: {error}"))
        return self.bus.writer(message, topic).publish(made, subscribers, timeout)

    def transform(self, target: str, source: str, timeout: float, at: float | None = None) -> Operation[Pose]:
        """Return the pose of frame `source` in frame `target`, now or at a time [s]."""
        return self.transforms.lookup(target, source, timeout, at)

    def get_parameter(self, node: str, name: str, timeout: float) -> Operation[Any]:
        service = "rcl_interfaces/srv/GetParameters"

        def value(response: Message) -> Operation[Any]:
            (found,) = response.values or (None,)
            held = None if found is None else parameter_value_to_python(found)
            if held is None:
                raise BadReplyError(f"{node}: there is no parameter {name!r}, or nobody has set it", node=node)
            return Operation.finished(held)

        return self.bus.call(service, f"{node}/get_parameters", timeout + ANSWER, timeout, names=[name]).then(value)

    def set_parameter(self, node: str, name: str, value: object, timeout: float) -> Operation[None]:
        service = "rcl_interfaces/srv/SetParameters"
        given: Any = value
        if isinstance(value, (list, tuple)) and {type(v) for v in value} == {int, float}:
            given = [float(v) for v in value]
        try:
            parameter = Parameter(
                name, Parameter.Type.STRING_ARRAY if isinstance(given, (list, tuple)) and not given else None, given
            )
        except TypeError:
            parameter = Parameter(name)
        if parameter.type_ == Parameter.Type.NOT_SET:
            allowed = "a truth value, a number, a text, or a list of one of these"
            return Operation.failed(BadReplyError(f"{node}: {name}: {value!r} can't be a parameter: {allowed}"))

        def check(response: Message) -> Operation[None]:
            (result,) = response.results
            if not result.successful:
                raise BadReplyError(f"{node} refuses {name} = {value!r}: {result.reason or 'it gave no reason'}")
            return Operation.finished(None)

        sent = {"parameters": [parameter.to_parameter_msg()]}
        return self.bus.call(service, f"{node}/set_parameters", timeout + ANSWER, timeout, **sent).then(check)


def _as(topic: str, message: Message, value: str) -> Operation[Any]:
    try:
        return Operation.finished(from_message(message, value))
    except ConversionError as error:
        raise BadReplyError(f"{topic}: {error}") from None


TOPIC, MESSAGE = "/clock", "rosgraph_msgs/msg/Clock"


class RosClock(Closing):
    """Implements `grip_bt.base.ports.Clock`: the simulator's time, 0 until it is first heard; never goes back.

    A simulator that starts again sends an earlier time: the clock then stands still until the simulator has caught up.
    """

    def __init__(self, bus: Bus):
        self._time = 0.0
        self._started = threading.Event()
        self._listeners: list[Callable[[], None]] = []
        self._bus, self._reader = bus, bus.reader(MESSAGE, TOPIC)
        self._reader.listen(self._received)

    def now(self) -> float:
        return self._time

    def wait_started(self, timeout: float) -> bool:
        """Wait until the time was heard; False after `timeout` [s] of the wall's time."""
        return self._started.wait(timeout)

    def publishers(self) -> str:
        """Say who publishes the time, and which topics are published instead."""
        return self._bus.ask(self._reader.publishers)

    def on_advance(self, listener: Callable[[], None]) -> None:
        """Have `listener()` called whenever time passes, on the bus's thread."""
        self._listeners.append(listener)

    def close(self) -> None:
        self._reader.ignore(self._received)

    def _received(self, received: Received) -> None:
        time = seconds(received.message.clock)
        self._started.set()
        if time > self._time:
            self._time = time
            for listener in list(self._listeners):
                listener()


OURS = 10.0
"""How far a stamp may lie before our own time to count as one of our clock [s]: others lie further back, or ahead."""


def together(
    bus: Bus, topics: Mapping[str, str], slop: float, timeout: float, now: Callable[[], float]
) -> Operation[Mapping[str, Message]]:
    """Wait for one message of each topic. Stamps decide; a message without one counts as taken when it came.

    What was taken before it was asked for is passed over, as far as the stamps tell: one that lies further back than
    `OURS` is of another clock, of which nothing is known.

    Args:
        slop: how far the stamps may be apart [s].
        timeout: how long to wait [s], then it ends with ServerTimeOutError; infinite for as long as it takes.
        now: the time of the clock of stamps [s].
    """
    whole: Operation[Mapping[str, Message]] = Operation()
    asked, matcher, early = now(), Synchroniser(topics, slop), dict[str, float]()
    readers = {topic: bus.reader(message, topic) for topic, message in topics.items()}

    def heard(topic: str, received: Received) -> None:
        if whole.done():
            return
        header = getattr(received.message, "header", None)
        stamp = seconds(header.stamp) if header is not None else 0.0
        if stamp and -OURS < stamp - asked < 0:
            early[topic] = asked - stamp
            return
        found = matcher.add(topic, stamp or now(), received.message)
        if found is not None:
            whole.succeed(found)

    def about(topic: str) -> str:
        if topic in early:
            return f"what came was taken before it was asked for, the last {early[topic]:.2f} s; do the clocks agree?"
        return readers[topic].publishers()

    def give_up() -> None:
        text = f"no set of messages within {timeout:.1f} s: {matcher.describe(about)}"
        if len(readers) == 1:
            (topic,) = readers
            text = f"{topic}: no message within {timeout:.1f} s; {about(topic)}"
        whole.fail(ServerTimeOutError(text, topics=list(readers)))

    for topic, reader in readers.items():
        listener = partial(heard, topic)
        reader.listen(listener)
        whole.add_done_callback(partial(reader.ignore, listener))
    if math.isfinite(timeout):
        timer = threading.Timer(timeout, lambda: bus.post(give_up))
        timer.daemon = True
        timer.start()
        whole.add_done_callback(timer.cancel)
    return whole


KEPT = 30
"""Messages of each topic that are kept while others are awaited."""


class Synchroniser:
    """Finds the first set of messages, one of each topic, whose stamps lie close together.

    Args:
        slop: how far the stamps of a set may be apart [s].
    """

    def __init__(self, topics: Iterable[str], slop: float):
        self.slop = slop
        self._kept: dict[str, deque[tuple[float, Message]]] = {topic: deque(maxlen=KEPT) for topic in topics}

    def add(self, topic: str, stamp: float, message: Message) -> dict[str, Message] | None:
        """Add a message; return the set that it completes, the one that lies closest together, or None.

        Args:
            stamp: when it was taken [s].
        """
        self._kept[topic].append((stamp, message))
        nearest = {}
        for name, kept in self._kept.items():
            if not kept:
                return None
            nearest[name] = (stamp, message) if name == topic else min(kept, key=lambda entry: abs(entry[0] - stamp))
        stamps = [entry[0] for entry in nearest.values()]
        if max(stamps) - min(stamps) > self.slop:
            return None
        return {name: entry[1] for name, entry in nearest.items()}

    def describe(self, about: Callable[[str], str]) -> str:
        """Say what came so far, for the error of a wait that ends in vain; `about` says why a topic gave nothing."""
        if silent := [topic for topic, kept in self._kept.items() if not kept]:
            return f"nothing came on {', '.join(f'{topic} ({about(topic)})' for topic in silent)}"
        last = [kept[-1][0] for kept in self._kept.values()]
        return f"the last stamps are {max(last) - min(last):.3f} s apart, at most {self.slop:.3f} s are allowed"
