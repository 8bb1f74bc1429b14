"""Machines seen and set from outside: the three topics that smach_viewer and its kin know.

`<server>/smach/container_structure` and `.../container_status` say what there is and where it is; a message on
`.../container_init` says where a container begins next. Userdata travels as a pickle, as upstream. It is sent; what
comes from the network is unpickled only with the setting `unpickle_userdata`, since a pickle may run any code.
"""

from __future__ import annotations

import importlib
import pickle
import sys
import threading
import traceback
from contextlib import suppress
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.smach_compat._settings import hooks, settings
from grip_bt.smach_compat.container import Container
from grip_bt.smach_compat.user_data import UserData

from ._connection import ros, seconds, with_optional_node

__all__ = ["IntrospectionClient", "IntrospectionServer"]

STATUS_TOPIC = "/smach/container_status"
INIT_TOPIC = "/smach/container_init"
STRUCTURE_TOPIC = "/smach/container_structure"
HEARTBEAT = 2.0
"""How often structure and status are sent when nothing happens [s]."""
REPEAT = 0.3
"""How often a client repeats its command until the status shows it [s]."""
_NO_DATA = tuple(pickle.dumps({}, protocol) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)) + (
    b"",
    b"\x80\x02}q\x01.",  # Python 2's C pickler counts from one
)
_REFUSED = (
    "it comes with pickled userdata, which may run any code when it is read; if everybody who can reach this network "
    "is trusted, allow it: grip_bt.smach_compat.configure(unpickle_userdata=True)"
)


class IntrospectionClient:
    """Finds servers and sets where their containers begin. A node's name or a node is accepted and not needed."""

    def __init__(self, *_names: object, **_options: object):
        pass

    def get_servers(self) -> list[str]:
        """Return the names of the servers that send their status."""
        topics = ros().topics_of(ros().introspection().Status)
        return [topic[: -len(STATUS_TOPIC)] for topic in topics if topic.endswith(STATUS_TOPIC)]

    def set_initial_state(
        self,
        server: str,
        path: str,
        initial_states: list[str],
        initial_userdata: UserData | None = None,
        timeout: Any = None,
    ) -> bool | None:
        """Let a container begin at these states, with this userdata.

        Returns:
            Whether the server has confirmed within `timeout` (a duration or [s]); None without.

        Raises:
            GripError: userdata can't be confirmed, since that means to read the server's pickle.
        """
        data = {} if initial_userdata is None else initial_userdata._data
        if data and timeout is not None and not settings.unpickle_userdata:
            raise GripError(f"The answer of {server!r} can't be compared with the userdata: {_REFUSED}")
        messages = ros().introspection()
        command = messages.InitialStatusCmd(
            path=path, initial_states=list(initial_states), local_data=messages.packed(_pickled(data))
        )
        confirmed = threading.Event()

        def hear(status: Any) -> None:
            if status.path == path and set(initial_states) <= set(status.initial_states):
                packed = messages.unpacked(status.local_data) if data else b""
                there = {} if packed in _NO_DATA else pickle.loads(packed)  # asked for, since there is data
                if all(key in there and there[key] == value for key, value in data.items()):
                    confirmed.set()

        status = ros().subscribe(server + STATUS_TOPIC, messages.Status, hear)
        init = ros().advertise(server + INIT_TOPIC, messages.InitialStatusCmd)
        try:
            init.publish(command)
            return None if timeout is None else self._until(confirmed, lambda: init.publish(command), timeout)
        finally:
            status.close()
            if timeout is not None:  # else it would take the command along, that is still under way
                init.close()

    @staticmethod
    def _until(confirmed: threading.Event, repeat: Any, timeout: Any) -> bool:
        deadline = ros().now() + seconds(timeout)
        while ros().now() < deadline and not ros().is_shutdown():
            repeat()
            if confirmed.wait(min(REPEAT, max(0.0, deadline - ros().now()))):
                return True
        return False


class ContainerProxy:
    """One container on the network."""

    def __init__(self, server_name: str, container: Any, path: str, update_rate: Any = HEARTBEAT):
        self._container, self._path, self._period = container, path, seconds(update_rate)
        self._messages = ros().introspection()
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._structure = ros().advertise(server_name + STRUCTURE_TOPIC, self._messages.Structure)
        self._status = ros().advertise(server_name + STATUS_TOPIC, self._messages.Status)
        self._init = ros().subscribe(server_name + INIT_TOPIC, self._messages.InitialStatusCmd, self._init_cmd_cb)
        self._beat = threading.Thread(target=self._beats, name=f"{server_name}:introspection {path}", daemon=True)
        container.register_transition_cb(lambda *args, **kwargs: self._publish_status(f"{args}, {kwargs}"))

    def start(self) -> None:
        self._beat.start()

    def stop(self) -> None:
        self._stopped.set()
        for end in (self._init, self._structure, self._status):
            end.close()

    def _beats(self) -> None:
        while not self._stopped.is_set() and not ros().is_shutdown():
            self._publish_structure("HEARTBEAT")
            self._publish_status("HEARTBEAT")
            self._stopped.wait(self._period)

    def _publish_structure(self, info_str: str = "") -> None:
        container = self._container
        edges = container.get_internal_edges()
        message = self._messages.Structure(
            header=self._messages.header(),
            path=self._path,
            children=[str(label) for label in container.get_children()],
            internal_outcomes=[str(outcome) for outcome, _, _ in edges],
            outcomes_from=[str(label) for _, label, _ in edges],
            outcomes_to=[str(target) for _, _, target in edges],
            container_outcomes=[str(outcome) for outcome in container.get_registered_outcomes()],
        )
        self._send(self._structure, message)

    def _publish_status(self, info_str: str = "") -> None:
        with self._lock:
            message = self._messages.Status(
                header=self._messages.header(),
                path=self._path,
                initial_states=list(self._container.get_initial_states()),
                active_states=list(self._container.get_active_states()),
                local_data=self._messages.packed(_pickled(self._container.userdata._data)),
                info=info_str,
            )
            self._send(self._status, message)

    def _send(self, publisher: Any, message: Any) -> None:
        if self._stopped.is_set() or ros().is_shutdown():
            return
        try:
            publisher.publish(message)
        except Exception:  # noqa: BLE001 - a spectator must not stop the machine
            hooks.logerr(f"Sending introspection of {self._path!r} failed: {traceback.format_exc()}")

    def _init_cmd_cb(self, command: Any) -> None:
        if command.path != self._path or self._stopped.is_set():
            return
        children = self._container.get_children()
        if not all(state in children for state in command.initial_states):
            hooks.logerr(
                f"Container {self._path!r} can't start at {list(command.initial_states)}: it has {list(children)}"
            )
            return
        data = self._messages.unpacked(command.local_data)
        userdata = UserData()
        if data not in _NO_DATA:
            if not settings.unpickle_userdata:
                hooks.logerr(f"A command to start at {list(command.initial_states)} was refused: {_REFUSED}")
                return
            userdata._data = pickle.loads(data)
        self._container.set_initial_state(list(command.initial_states), userdata)
        self._publish_status("REMOTE_INIT")


class IntrospectionServer:
    """Puts a container, and those inside it, on the network.

    In profile `ros2`, a program that has called `rclpy.init` gets one that is a node of rclpy too.
    """

    def __new__(cls, *_: object, **__: object) -> Any:
        rclpy = sys.modules.get("rclpy")
        if settings.ros2 and cls.__module__ == __name__ and rclpy is not None and rclpy.ok():
            cls = importlib.import_module("grip_bt.ros.smach_rclpy").IntrospectionServerNode
        return super().__new__(cls)

    @with_optional_node
    def __init__(self, server_name: str, state: object, path: str):
        self._server_name, self._state, self._path = server_name, state, path
        self._proxies: list[ContainerProxy] = []

    def start(self) -> None:
        name = ros().name_of(self._server_name, self._node)  # type: ignore[attr-defined]  # set by with_optional_node
        self.construct(name, self._state, self._path)

    def stop(self) -> None:
        for proxy in self._proxies:
            proxy.stop()

    def construct(self, server_name: str, state: Any, path: str) -> None:
        proxy = ContainerProxy(server_name, state, path)
        inner = "" if path == "/" else path
        for label, child in state.get_children().items():
            if isinstance(child, Container):
                self.construct(server_name, child, f"{inner}/{label}")
        proxy._publish_status("Initial state")
        proxy.start()
        self._proxies.append(proxy)

    def clear(self) -> None:
        self._proxies = []


def _pickled(data: dict[str, Any]) -> bytes:
    """Return values as a pickle that Python 2 reads too; what can't be pickled is left out and said so."""
    try:
        return pickle.dumps(data, 2)
    except Exception:  # noqa: BLE001 - upstream raises here, and the container logs it at each transition
        kept = {}
        for key, value in data.items():
            with suppress(Exception):  # pickling calls the user's code, which may raise anything
                pickle.dumps(value, 2)
                kept[key] = value
        hooks.logdebug(f"Userdata that can't be pickled isn't shown: {sorted(set(data) - set(kept))}")
        return pickle.dumps(kept, 2)
