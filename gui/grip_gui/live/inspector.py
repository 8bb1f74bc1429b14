"""What the process that looks at ROS can do: topics, one message of a topic, a server's named messages."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

from grip_bt.app.project.folder import find_project
from grip_bt.base.failures import ExpectedError
from grip_bt.base.message_store.text import fields_of
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.graph import topics
from grip_bt.ros.client.types import load_type, type_name
from grip_bt.ros.messages import MessageServer, RosMessages
from grip_bt.ros.messages.wire import MESSAGES as STORES
from grip_bt.ros.messages.wire import entry_rows, pack, text_of_entry
from grip_bt.task.catalog.ros_config import MESSAGES
from grip_gui.live.message_view import message_view

APPEARS = 2.0  # how long a server of messages may take to be found [s]
ANSWERS = 10.0
FOUND = 1.5  # how long the graph is looked at before what is in it counts as all [s]


class RosInspector:
    """One connection to ROS, in the user's own domain."""

    def __init__(self) -> None:
        self._bus = Bus("grip_editor")
        self.domain = str(self._bus.domain_id)
        self._began = time.monotonic()
        self._messages = RosMessages(self._bus, wait=APPEARS)
        self._server: Bus | None = None
        self._lock = threading.Lock()

    def topics(self) -> dict[str, Any]:
        """Return the topics that somebody publishes."""
        time.sleep(max(0.0, self._began + FOUND - time.monotonic()))  # others are found within that
        operation = self._bus.post(lambda: topics(self._bus.node))
        operation.wait(ANSWERS)
        of = {message: value for value, message in reversed(MESSAGES.items())}
        rows = [
            {"name": name, "type": types[0], "value": of.get(types[0], types[0]), "publishers": publishers}
            for name, types, publishers in operation.result()
        ]
        return {"topics": rows, "domain": self.domain}

    def receive(self, topic: str, type: str, within: float) -> dict[str, Any]:
        """Wait for the next message of a topic."""
        began = time.monotonic()
        operation = self._bus.reader(load_type(type), topic).next(within)
        operation.wait(within + 1.0)
        view = message_view(type, operation.result())
        return {"value": view.model_dump(), "seconds": time.monotonic() - began}

    def messages(self) -> dict[str, Any]:
        """Return what a server of messages has."""
        ours = self._server is not None
        answer = self._done(self._messages.listing())
        rows = entry_rows(answer)
        stores = [
            {"name": name, "type": STORES.get(name, type_), "queued": queued}
            for name, type_, queued in zip(answer.stores, answer.types, answer.queued, strict=True)
        ]
        return {"served": True, "ours": ours, "stores": stores, "messages": rows, "domain": self.domain}

    def message(self, store: str, name: str) -> dict[str, Any]:
        """Return one of them, looked at, and as text where it can be changed as one."""
        entry = self._done(self._messages.get(store, name))
        kind = type(entry.value)
        view = message_view(kind.__name__ if fields_of(entry.value) is None else type_name(kind), entry.value)
        return {"value": view.model_dump(), "text": text_of_entry(store, pack(store, entry.value))}

    def put(self, store: str, name: str, type: str, text: str) -> None:
        """Add or replace one."""
        self._done(self._messages.put_text(store, name, text, type, "by hand in the editor"))

    def delete(self, store: str, name: str) -> None:
        """Remove one."""
        self._done(self._messages.delete(store, name))

    def reset(self, store: str) -> None:
        """Empty a store, or all, and have the server read its files again."""
        self._done(self._messages.reset(store))

    def save(self) -> dict[str, Any]:
        """Have the server keep everything."""
        return {"count": self._done(self._messages.save())}

    def serve(self) -> None:
        """Serve the messages of the project of this folder."""
        with self._lock:
            if self._server is not None:
                return
            project = find_project(Path.cwd())
            bus = Bus("grip_messages", domain_id=int(self.domain))
            try:
                MessageServer(bus, project.folder / "messages", project.state_folder / "messages.sqlite")
            except BaseException:
                bus.close()
                raise
            self._server = bus

    def end(self) -> None:
        """Serve no more."""
        with self._lock:
            bus, self._server = self._server, None
        if bus is not None:
            bus.close()

    def close(self) -> None:
        """Leave the graph."""
        self.end()
        self._bus.close()

    def _done(self, operation: Any) -> Any:
        if not operation.wait(ANSWERS):
            raise ExpectedError("the message server does not answer")
        return operation.result()
