"""Named messages of a server in another process, behind the port `Messages`."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any, TypeVar

from grip_bt.base.failures import BadReplyError, EmptyQueueError, NoEntryError
from grip_bt.base.message_store import Entry
from grip_bt.base.operation import Operation

from ..client.bus import Bus
from ..client.topic import Received
from ..client.types import ConversionError, Message, load_type
from ..convert_values import seconds
from ..interface import BadRequestError
from ..interfaces.build import ensure_package
from .wire import CHANGES, PREFIX, RawMessage, message_of, pack, unpack

T = TypeVar("T")


class RosMessages:
    """Implements `grip_bt.base.ports.Messages` over ROS 2.

    Standard stores take and give GRIP's values; all stores take messages of any type, and others give them.

    Args:
        timeout: how long one request may take [s].
        wait: how long to wait for the server to appear [s].
    """

    def __init__(self, bus: Bus, prefix: str = PREFIX, timeout: float = 10.0, wait: float = 5.0):
        ensure_package("grip_msgs")
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
        return self._call("add", "AddMessage", lambda answer: BadReplyError(answer.message), entry=entry).then(_nothing)

    def get(self, store: str, name: str) -> Operation[Entry[Any]]:
        """Return an entry; without a name the oldest of the store's queue, which is removed."""
        return self._entry(store, name, unpack)

    def message(self, store: str, name: str) -> Operation[Entry[Message]]:
        """Return an entry with its ROS message as it was sent, header and all; otherwise like `get`."""
        return self._entry(store, name, lambda _, raw: message_of(raw))

    def _entry(self, store: str, name: str, read: Callable[[str, RawMessage], T]) -> Operation[Entry[T]]:
        def refusal(answer: Message) -> Exception:
            empty = answer.code == EmptyQueueError.code
            return EmptyQueueError(store) if empty else NoEntryError(answer.message)

        def entry(answer: Message) -> Operation[Entry[T]]:
            found = answer.entry
            try:
                value = read(store, RawMessage(found.type, bytes(found.data)))
            except (ConversionError, BadRequestError) as error:
                raise BadReplyError(f"store {store!r}: {found.name!r}: {error}") from None
            made = Entry(found.name, value, seconds(found.stamp), found.provenance, found.revision)
            return Operation.finished(made)

        return self._call("get", "GetMessage", refusal, store=store, name=name).then(entry)

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store."""
        answer = self._call("list", "ListMessages", store=store)
        return answer.then(lambda answer: Operation.finished(tuple(entry.name for entry in answer.entries)))

    def listing(self) -> Operation[Message]:
        """Return the server's whole answer to `list`: entries, stores, and the lengths of their queues."""
        return self._call("list", "ListMessages", store="")

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry."""
        return self._call("delete", "DeleteMessage", store=store, name=name).then(_nothing)

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and have the server read its project's files again."""
        return self._call("reset", "ResetMessages", store=store).then(_nothing)

    def save(self) -> Operation[int]:
        """Have the server keep everything for later runs; return how many entries there are."""
        answer = self._call("save", "SaveMessages", lambda answer: BadReplyError(answer.message))
        return answer.then(lambda answer: Operation.finished(answer.count))

    def next_of(self, topic: str, type_: str, within: float) -> Message:
        """Wait for the next message of a topic and return it, so that it can be put; for scripts, it blocks.

        Args:
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
            callback(entry.store, CHANGES[received.message.kind], entry.name, value)

        reader.listen(heard).wait(self._timeout)
        return lambda: reader.ignore(heard)

    def _call(
        self,
        service: str,
        type_: str,
        refusal: Callable[[Message], Exception] = lambda answer: NoEntryError(answer.message),
        **fields: object,
    ) -> Operation[Message]:
        cls = load_type(f"grip_msgs/srv/{type_}")
        client = self._bus.service(cls, f"{self._prefix}/{service}")

        def check(answer: Message) -> Operation[Message]:
            return Operation.finished(answer) if answer.success else Operation.failed(refusal(answer))

        return client.call(cls.Request(**fields), self._timeout, self._wait).then(check)


def _nothing(answer: Message) -> Operation[None]:
    return Operation.finished(None)
