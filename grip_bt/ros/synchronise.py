"""Messages of several topics that were taken together, after they were asked for."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping

from grip_bt.base.failures import ServerTimeOutError
from grip_bt.base.operation import Operation

from .client.bus import Bus
from .client.graph import MOST
from .client.topic import Received, TopicReader
from .client.types import Message
from .convert_geometry import seconds

OURS = 1.0
"""How far a stamp may lie before our own time to count as one of our clock [s]."""


class Gathering:
    """Waits for one message of each topic. Stamps decide; a message without one counts as taken when it came.

    What was taken before it was asked for is passed over, as far as the stamps tell: one that lies further back than
    `OURS` is of another clock, of which nothing is known.

    Args:
        bus: the connection to ROS.
        topics: topic -> its ROS type.
        slop: how far the stamps may be apart [s].
        timeout: how long to wait [s]; infinite for as long as it takes.
        now: the time of the clock of stamps [s].
    """

    def __init__(
        self, bus: Bus, topics: Mapping[str, str], slop: float, timeout: float, now: Callable[[], float]
    ) -> None:
        self.whole: Operation[Mapping[str, Message]] = Operation()
        self._now, self._asked, self._timeout = now, now(), timeout
        self._matcher = Synchroniser(topics, slop)
        self._readers: dict[str, TopicReader] = {t: bus.reader(m, t) for t, m in topics.items()}
        self._early: dict[str, float] = {}
        self._bus = bus

    def begin(self) -> Operation[Mapping[str, Message]]:
        """Listen from now on; the operation ends with the messages by topic, or with ServerTimeOutError."""
        listeners = {t: (lambda received, t=t: self._heard(t, received)) for t in self._readers}
        for topic, reader in self._readers.items():
            reader.listen(listeners[topic])
        timer = threading.Timer(self._timeout, lambda: self._bus.post(self._give_up))
        timer.daemon = True
        if math.isfinite(self._timeout):
            timer.start()

        def clean() -> None:
            timer.cancel()
            for topic, reader in self._readers.items():
                reader.ignore(listeners[topic])

        self.whole.add_done_callback(clean)
        return self.whole

    # --- on the bus's thread ---

    def _heard(self, topic: str, received: Received) -> None:
        if self.whole.done():
            return
        header = getattr(received.message, "header", None)
        stamp = seconds(header.stamp) if header is not None else 0.0
        if not stamp:
            stamp = self._now()
        elif -OURS < stamp - self._asked < 0:
            self._early[topic] = self._asked - stamp
            return
        found = self._matcher.add(topic, stamp, received.message)
        if found is not None:
            self.whole.succeed(found)

    def _give_up(self) -> None:
        silent = self._matcher.silent()
        said = [f"{topic} ({self._about(topic, max(1, MOST // len(silent)))})" for topic in silent]
        if len(self._readers) == 1:
            (topic,) = self._readers
            text = f"{topic}: no message within {self._timeout:.1f} s; {self._about(topic)}"
        else:
            reason = f"nothing came on {', '.join(said)}" if silent else self._matcher.describe()
            text = f"no set of messages within {self._timeout:.1f} s: {reason}"
        self.whole.fail(ServerTimeOutError(text, topics=list(self._readers)))

    def _about(self, topic: str, most: int = MOST) -> str:
        """Say why a topic gave nothing; of those that are published instead, `most` are named."""
        if topic in self._early:
            return f"what came was taken before it was asked for, the last {self._early[topic]:.2f} s"
        return self._readers[topic].publishers(most)


KEPT = 30
"""Messages of each topic that are kept while others are awaited."""


class Synchroniser:
    """Finds the first set of messages, one of each topic, whose stamps lie close together.

    Args:
        topics: their names.
        slop: how far the stamps of a set may be apart [s].
    """

    def __init__(self, topics: Iterable[str], slop: float):
        self.slop = slop
        self._kept: dict[str, deque[tuple[float, Message]]] = {topic: deque(maxlen=KEPT) for topic in topics}

    def add(self, topic: str, stamp: float, message: Message) -> dict[str, Message] | None:
        """Add a message; return the set that it completes, the one that lies closest together, or None.

        Args:
            topic: where it came from.
            stamp: when it was taken [s].
            message: handed out as it is.
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

    def silent(self) -> list[str]:
        """Return the topics on which nothing came."""
        return [topic for topic, kept in self._kept.items() if not kept]

    def describe(self) -> str:
        """Say what came so far, for the error of a wait that ends in vain."""
        if silent := self.silent():
            return f"nothing came on {', '.join(silent)}"
        last = {topic: kept[-1][0] for topic, kept in self._kept.items()}
        apart = max(last.values()) - min(last.values())
        return f"the last stamps are {apart:.3f} s apart, at most {self.slop:.3f} s are allowed"
