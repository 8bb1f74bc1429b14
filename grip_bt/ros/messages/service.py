"""Named messages over ROS 2: the server, with stores of CDR behind services, and the port `Messages` over one."""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.failures import BadReplyError, EmptyQueueError, ExpectedError, NoEntryError
from grip_bt.base.message_store import Change, Entry, MessageLibrary, MessageStore, load, save
from grip_bt.base.operation import Operation

from ..client.bus import Bus
from ..client.topic import Received
from ..client.types import ConversionError, Message, load_type
from ..convert_values import seconds
from ..interface import BadRequestError
from ..interfaces.build import ensure_package
from .wire import CHANGES, MESSAGES, PREFIX, RawMessage, message_of, pack, text_of_entry, unpack, value_from_text

_DEPTH = 100


class WrongMessageError(GripError):
    """A store was given a message of another type than it holds."""

    def __init__(self, store: str, wanted: str, given: str):
        self.store, self.wanted, self.given = store, wanted, given
        super().__init__(f"store {store!r} holds {wanted}, not {given}")


class MessageServer:
    """Serves the messages of a project.

    Args:
        folder: holds the project's files of messages; None for none.
        archive: where `save` keeps everything, and what is read at the start when it is there; None for nowhere.

    Raises:
        DocumentError: a file of the folder is wrong.
    """

    def __init__(self, bus: Bus, folder: Path | None = None, archive: Path | None = None):
        ensure_package("grip_msgs")
        self._publisher: Publisher | None = None
        self._bus, self._folder, self._archive = bus, folder, archive
        self._types = dict(MESSAGES)
        self._library = MessageLibrary()
        self._raw: dict[str, MessageStore[RawMessage]] = {}
        for name in MESSAGES:
            self._made(name)
        self._entry = load_type("grip_msgs/msg/Entry")
        self._change = load_type("grip_msgs/msg/Change")
        self._reset("")
        if archive is not None and archive.is_file():
            load(self._made, archive, _decode)
            for name, store in self._raw.items():
                for entry in (*store.entries(), *store.queue()):
                    self._types.setdefault(name, entry.value.type)
        bus.ask(self._open, 5.0)

    def _open(self) -> None:
        node = self._bus.node
        self._publisher = node.create_publisher(self._change, f"{PREFIX}/changes", QoSProfile(depth=_DEPTH))
        for name, type_, work in (
            ("add", "AddMessage", self._on_add),
            ("get", "GetMessage", self._on_get),
            ("list", "ListMessages", self._on_list),
            ("delete", "DeleteMessage", lambda asked, _: self._store(asked.store).delete(asked.name)),
            ("reset", "ResetMessages", lambda asked, _: self._reset(asked.store and self._store(asked.store).name)),
            ("save", "SaveMessages", self._on_save),
        ):
            node.create_service(load_type(f"grip_msgs/srv/{type_}"), f"{PREFIX}/{name}", _answering(work))

    # --- services; on the bus's thread ---

    def _on_add(self, request: Message, response: Message) -> None:
        given = request.entry
        if not given.store:
            raise ExpectedError("the entry names no store")
        if given.data or not given.text:
            raw = RawMessage(given.type, bytes(given.data))
            message_of(raw)  # so that nobody is given what can't be read
        else:
            type_ = given.type or self._types.get(given.store, "")
            raw = pack(given.store, value_from_text(given.store, "value", given.text, type_, self._joint_states))
        wanted = self._types.setdefault(given.store, raw.type)
        if raw.type != wanted:
            raise WrongMessageError(given.store, wanted, raw.type)
        store, at = self._made(given.store), seconds(given.stamp) or None
        entry = (
            store.put(given.name, raw, given.provenance, at) if given.name else store.push(raw, given.provenance, at)
        )
        response.revision = entry.revision

    def _on_get(self, request: Message, response: Message) -> None:
        store = self._store(request.store)
        if not request.name and not store.queued:
            response.code = EmptyQueueError.code
        response.entry = self._message(request.store, store.entry(request.name) if request.name else store.take())

    def _on_list(self, request: Message, response: Message) -> None:
        chosen = {request.store: self._store(request.store)} if request.store else self._raw
        response.entries = [
            self._message(name, entry, data=False) for name, store in chosen.items() for entry in store.entries()
        ]
        response.stores = list(self._raw)
        response.types = [self._types.get(name, "") for name in self._raw]
        response.queued = [store.queued for store in self._raw.values()]

    def _on_save(self, request: Message, response: Message) -> None:
        file = Path(request.file) if request.file else self._archive
        if file is None:
            raise ExpectedError("this server belongs to no project; name a file")
        response.count = save(self._raw, file, lambda raw: json.dumps(raw.type).encode() + b"\n" + raw.data)

    # --- stores ---

    def _joint_states(self) -> dict[str, Any]:
        return {entry.name: unpack("joint_states", entry.value) for entry in self._raw["joint_states"].entries()}

    def _made(self, name: str) -> MessageStore[RawMessage]:
        if name not in self._raw:
            self._raw[name] = MessageStore(name, "Any")
            self._watch(name, self._raw[name])
        return self._raw[name]

    def _store(self, name: str) -> MessageStore[RawMessage]:
        if name not in self._raw:
            raise UnknownNameError("store", name, self._raw)
        return self._raw[name]

    def _reset(self, name: str) -> None:
        fresh = MessageLibrary(self._folder) if self._folder is not None else self._library
        for key, store in self._raw.items():
            if name in ("", key):
                store.clear()
                if key in fresh.stores():
                    for entry in fresh.store(key).entries():
                        store.put(entry.name, pack(key, entry.value), entry.provenance)

    def _watch(self, name: str, store: MessageStore[RawMessage]) -> None:
        def tell(change: Change[RawMessage]) -> None:
            if self._publisher is None or not self._publisher.get_subscription_count():
                return  # while the stores are first filled; and nobody listens, which saves a copy of a cloud
            entry = self._entry(store=name, name=change.name, revision=change.revision)
            if change.value is not None:
                entry.type, entry.data = change.value.type, array("B", change.value.data)
            self._publisher.publish(self._change(kind=CHANGES.index(change.kind), entry=entry))

        store.watch(tell)

    def _message(self, store: str, entry: Entry[RawMessage], data: bool = True) -> Message:
        nanoseconds = round(entry.time * 1e9)
        made = self._entry(store=store, name=entry.name, type=entry.value.type, revision=entry.revision)
        made.provenance = entry.provenance
        made.stamp.sec, made.stamp.nanosec = nanoseconds // 10**9, nanoseconds % 10**9
        if data:
            made.data = array("B", entry.value.data)  # bytes are a thousand times slower
            made.text = text_of_entry(store, entry.value)
        return made


def _decode(content: bytes) -> RawMessage:
    type_, _, data = content.partition(b"\n")
    return RawMessage(json.loads(type_), data)


def _answering(work: Callable[[Message, Message], None]) -> Callable[[Message, Message], Message]:
    """Return a service's callback: what goes wrong is said in the answer, and the server goes on."""

    def answer(request: Message, response: Message) -> Message:
        try:
            work(request, response)
            response.success = True
        except (GripError, ValueError, OSError) as error:
            response.success, response.message = False, str(error)
        return response

    return answer


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
        return self._put(store=store, name=name, type=raw.type, provenance=provenance, data=array("B", raw.data))

    def put_text(self, store: str, name: str, text: str, type_: str = "", provenance: str = "") -> Operation[None]:
        """Put what a text says: YAML as in a project's files, or field by field; `type_`: of a new store's messages."""
        return self._put(store=store, name=name, type=type_, provenance=provenance, text=text)

    def _put(self, **fields: object) -> Operation[None]:
        entry = load_type("grip_msgs/msg/Entry")(**fields)
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
        answer = self._call("list", "ListMessages", store=store)
        return answer.then(lambda answer: Operation.finished(tuple(entry.name for entry in answer.entries)))

    def listing(self) -> Operation[Message]:
        """Return the server's whole answer to `list`: entries, stores, and the lengths of their queues."""
        return self._call("list", "ListMessages", store="")

    def delete(self, store: str, name: str) -> Operation[None]:
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
        def check(answer: Message) -> Operation[Message]:
            return Operation.finished(answer) if answer.success else Operation.failed(refusal(answer))

        name = f"{self._prefix}/{service}"
        return self._bus.call(f"grip_msgs/srv/{type_}", name, self._timeout, self._wait, **fields).then(check)


def _nothing(answer: Message) -> Operation[None]:
    return Operation.finished(None)
