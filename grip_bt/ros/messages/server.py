"""The server of named messages: stores of CDR behind services, told of on a topic."""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable
from pathlib import Path

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.failures import EmptyQueueError, ExpectedError
from grip_bt.base.message_store import Change, Entry, MessageLibrary, MessageStore, load, save

from ..client.bus import Bus
from ..client.types import Message, load_type
from ..convert_values import seconds
from ..interfaces.build import ensure_package
from .wire import CHANGES, MESSAGES, PREFIX, RawMessage, message_of, pack

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
            ("delete", "DeleteMessage", self._on_delete),
            ("reset", "ResetMessages", self._on_reset),
            ("save", "SaveMessages", self._on_save),
        ):
            node.create_service(load_type(f"grip_msgs/srv/{type_}"), f"{PREFIX}/{name}", _answering(work))

    # --- services; on the bus's thread ---

    def _on_add(self, request: Message, response: Message) -> None:
        given = request.entry
        if not given.store:
            raise ExpectedError("the entry names no store")
        raw = RawMessage(given.type, bytes(given.data))
        message_of(raw)  # so that nobody is given what can't be read
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
        response.queued = [store.queued for store in self._raw.values()]

    def _on_delete(self, request: Message, response: Message) -> None:
        self._store(request.store).delete(request.name)

    def _on_reset(self, request: Message, response: Message) -> None:
        if request.store:
            self._store(request.store)
        self._reset(request.store)

    def _on_save(self, request: Message, response: Message) -> None:
        file = Path(request.file) if request.file else self._archive
        if file is None:
            raise ExpectedError("this server belongs to no project; name a file")
        response.count = save(self._raw, file, lambda raw: json.dumps(raw.type).encode() + b"\n" + raw.data)

    # --- stores ---

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
