"""Named messages of a server in another process, behind the port `Messages`."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

from grip_bt.base.failures import BadReplyError, EmptyQueueError, NoEntryError
from grip_bt.base.message_store import Entry
from grip_bt.base.operation import Operation

from ..client.bus import Bus
from ..client.topic import Received
from ..client.types import ConversionError, Message, load_type
from ..convert_geometry import seconds
from ..interface import BadRequestError
from ..interfaces.build import provide
from .wire import PREFIX, RawMessage, message_of, pack, unpack

_KINDS = ("put", "deleted", "pushed", "taken")


class RosMessages:
    """Implements `grip_bt.base.ports.Messages` over ROS 2.

    Standard stores take and give GRIP's values; all stores take messages of any type, and others give them.

    Args:
        bus: the connection to ROS.
        prefix: name space of the server.
        timeout: how long one request may take [s].
        wait: how long to wait for the server to appear [s].
    """

    def __init__(self, bus: Bus, prefix: str = PREFIX, timeout: float = 10.0, wait: float = 5.0):
        provide("grip_msgs")
        self._bus, self._prefix, self._timeout, self._wait = bus, prefix, timeout, wait

    def put(self, store: str, name: str, value: object, provenance: str = "") -> Operation[None]:
        """Add or replace a message; without a name it goes to the end of the store's queue.

        Ends with BadRequestError when the value can't be the store's message, BadReplyError when the server refuses.
        """
        try:
            raw = pack(store, value)
        except BadRequestError as error:
            return Operation.failed(error)
        entry = load_type("grip_msgs/msg/Entry")(store=store, name=name, type=raw.type, provenance=provenance)
        entry.data = array("B", raw.data)
        return self._ask("add", "AddMessage", BadReplyError, entry=entry).then(lambda _: Operation.finished(None))

    def get(self, store: str, name: str) -> Operation[Entry[Any]]:
        """Return an entry; without a name the oldest of the store's queue, which is removed."""
        return self._asked_for(store, name, unpack)

    def message(self, store: str, name: str) -> Operation[Entry[Any]]:
        """Return an entry with its ROS message as it was sent, header and all; otherwise like `get`."""
        return self._asked_for(store, name, lambda _, raw: message_of(raw))

    def _asked_for(self, store: str, name: str, read: Callable[[str, RawMessage], Any]) -> Operation[Entry[Any]]:
        def refusal(answer: Message) -> Exception:
            empty = answer.code == EmptyQueueError.code
            return EmptyQueueError(store) if empty else NoEntryError(answer.message)

        asked = self._call("get", "GetMessage", refusal, store=store, name=name)
        return asked.then(lambda answer: _entry(store, answer.entry, read))

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store."""
        return self.entries(store).then(lambda entries: Operation.finished(tuple(e.name for e in entries)))

    def entries(self, store: str = "") -> Operation[tuple[Entry[None], ...]]:
        """Return what is known of the entries of a store, or of all, without their values."""

        def read(answer: Message) -> Operation[tuple[Entry[None], ...]]:
            found = (Entry(e.name, None, seconds(e.stamp), e.provenance, e.revision) for e in answer.entries)
            return Operation.finished(tuple(found))

        return self._ask("list", "ListMessages", NoEntryError, store=store).then(read)

    def listing(self) -> Operation[Message]:
        """Return the server's whole answer to `list`: entries, stores, and the lengths of their queues."""
        return self._ask("list", "ListMessages", NoEntryError, store="")

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry."""
        return self._done("delete", "DeleteMessage", store=store, name=name)

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and have the server read its project's files again."""
        return self._done("reset", "ResetMessages", store=store)

    def save(self) -> Operation[int]:
        """Have the server keep everything for later runs; return how many entries there are."""
        return self._ask("save", "SaveMessages", BadReplyError).then(lambda answer: Operation.finished(answer.count))

    def next_of(self, topic: str, type_: str, within: float) -> Message:
        """Wait for the next message of a topic and return it, so that it can be put; for scripts, it blocks.

        Args:
            topic: its full name.
            type_: its ROS type; empty for what it is published as.
            within: how long to wait [s].

        Raises:
            ServerTimeOutError: nothing came; it tells who publishes what.
        """
        operation = self._bus.reader(type_, topic).next(within)
        operation.wait(within + self._timeout)
        return operation.result()

    def watch(self, callback: Callable[[str, str, str, Any], None]) -> Callable[[], None]:
        """Call `callback(store, kind, name, value)` for each change, on the bus's thread; return what ends that.

        `kind` is `put`, `deleted`, `pushed` or `taken`; the value is None where it was deleted.
        """
        reader = self._bus.reader("grip_msgs/msg/Change", f"{self._prefix}/changes")

        def heard(received: Received) -> None:
            entry = received.message.entry
            raw = RawMessage(entry.type, bytes(entry.data))
            value = unpack(entry.store, raw) if entry.type else None
            callback(entry.store, _KINDS[received.message.kind], entry.name, value)

        reader.listen(heard).wait(self._timeout)
        return lambda: reader.ignore(heard)

    def _done(self, service: str, type_: str, **fields: object) -> Operation[None]:
        return self._ask(service, type_, NoEntryError, **fields).then(lambda _: Operation.finished(None))

    def _ask(
        self, service: str, type_: str, refusal: Callable[[str], Exception], **fields: object
    ) -> Operation[Message]:
        return self._call(service, type_, lambda answer: refusal(answer.message), **fields)

    def _call(
        self, service: str, type_: str, refusal: Callable[[Message], Exception], **fields: object
    ) -> Operation[Message]:
        cls = load_type(f"grip_msgs/srv/{type_}")
        client = self._bus.service(cls, f"{self._prefix}/{service}")

        def check(answer: Message) -> Operation[Message]:
            return Operation.finished(answer) if answer.success else Operation.failed(refusal(answer))

        return client.call(cls.Request(**fields), self._timeout, self._wait).then(check)


def _entry(store: str, message: Message, read: Callable[[str, RawMessage], Any]) -> Operation[Entry[Any]]:
    try:
        value = read(store, RawMessage(message.type, bytes(message.data)))
    except (ConversionError, BadRequestError) as error:
        raise BadReplyError(f"store {store!r}: {message.name!r}: {error}") from None
    return Operation.finished(Entry(message.name, value, seconds(message.stamp), message.provenance, message.revision))
