"""The connection to ROS of a process, with the clients that live on it; nothing else creates a client.

rclpy itself never says that a server died or that a type was wrong, and never gives up; so each call has a deadline, is
checked before it is sent, and is watched while it is under way (`grip_bt.ros.client.base`).
"""

from __future__ import annotations

from typing import Any, TypeVar, cast

from grip_bt.base.errors import GripError
from grip_bt.base.operation import Operation
from grip_bt.task.catalog.component_file import Qos

from .action import ActionClient
from .base import Client
from .connection import Connection
from .service import ServiceClient
from .topic import TopicReader, TopicWriter
from .types import InterfaceType, Message, check_name, load_type, type_name

C = TypeVar("C", ServiceClient, ActionClient, TopicReader, TopicWriter)


class Bus(Connection):
    """A ROS node with its thread, and one client of each name; see `Connection` for its arguments.

    Attributes:
        qos: topic -> the quality of service of its reader or writer, to be put in before that is made.
    """

    def __init__(self, name: str = "grip", domain_id: int | None = None, watched: bool = False):
        self._clients: dict[tuple[type, str], ServiceClient | ActionClient | TopicReader | TopicWriter] = {}
        self.qos: dict[str, Qos] = {}
        super().__init__(name, domain_id, watched)

    def service(self, interface: str | InterfaceType, name: str) -> ServiceClient:
        """Return the client of a service; there is one per name.

        Args:
            interface: the service's type, or its name.
            name: the service's full name, such as `/propose_grasps`.

        Raises:
            UnknownNameError, MissingPartError: there is no such type.
            GripError: a client of the name exists with another type, or ROS knows no such names.
        """
        return self._client(ServiceClient, interface, name)

    def call(self, interface: str, name: str, timeout: float, wait: float, /, **fields: object) -> Operation[Message]:
        """Call a service with a request of these fields; see `ServiceClient.call`."""
        client = self.service(interface, name)
        return client.call(client.type.Request(**fields), timeout, wait)

    def action(self, interface: str | InterfaceType, name: str) -> ActionClient:
        """Return the client of an action, likewise."""
        return self._client(ActionClient, interface, name)

    def reader(self, interface: str | InterfaceType, name: str) -> TopicReader:
        """Return the subscription of a topic, likewise.

        Without an interface (empty) it is subscribed to as what it is published as.
        """
        return self._client(TopicReader, interface, name)

    def writer(self, interface: str | InterfaceType, name: str) -> TopicWriter:
        """Return the publisher of a topic, likewise."""
        return self._client(TopicWriter, interface, name)

    def _client(self, kind: type[C], interface: str | InterfaceType, name: str) -> C:
        check_name(name)
        type_: Any = load_type(interface) if isinstance(interface, str) and interface else interface or None
        with self._lock:
            client = self._clients.get((kind, name))
            other = client is not None and type_ is not None and client.type is not type_
            if client is not None and client.type is None:
                client.type = type_
            elif client is None or (other and client.idle):
                client = self._clients[kind, name] = kind(self, type_, name)
                client.qos = self.qos.get(name, client.qos)
            elif other:
                raise GripError(f"{name} is used as {type_name(client.type)} already, not as {type_name(type_)}")
        return cast(C, client)

    def _polled(self) -> list[Client[Any]]:
        with self._lock:
            return list(self._clients.values())
