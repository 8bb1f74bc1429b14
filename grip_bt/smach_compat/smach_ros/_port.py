"""What `smach_ros` and `rospy` ask of ROS, and ROS within one process, which needs no network.

`grip_bt.ros.smach_rclpy` derives from it. All callbacks come on threads of the adapter; times are seconds of ROS time.
"""

from __future__ import annotations

import queue
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any

Logger = Callable[[object], object]
Callback = Callable[[Any], None]
_PERIOD, _MOMENT = 0.05, 0.001


class ServiceFailedError(Exception):
    """A service call ended without an answer."""


class NoFrameError(Exception):
    """A frame isn't known."""


@dataclass
class End:
    """One end of a topic, or a server: what somebody has and gives back."""

    close: Callable[[], Any]
    publish: Callback = lambda message: None
    listeners: Callable[[], int] = int


class Service:
    """The client of a service."""

    def __init__(self, ros: Ros, name: str, type_: Any):
        self._ros, self._name, self._type = ros, name, type_

    def wait(self, timeout: float) -> bool:
        return self._ros.wait_for_server(self._name, timeout)

    def call(self, request: Any) -> Any:
        serve = self._ros.services.get(self._name)
        if serve is None:
            return self._ros.made_up(f"service {self._name}", self._type.Response)
        try:
            answer = serve(request)
        except Exception as error:
            raise ServiceFailedError(f"service {self._name} responded with an error: {error}") from error
        if answer is None:
            raise ServiceFailedError(f"service {self._name} returned no response")
        return answer


class Goal:
    """A goal on its way; `done(ending, status, result)` is called once, at its end."""

    def __init__(self, message: Any, done: Callable[[str, int, Any], None], feedback: Callback):
        self.message, self._done, self.feedback = message, done, feedback
        self.canceled = self.over = False

    def begin(self) -> None:
        """Be worked on from now on."""

    def end(self, ending: str, result: object) -> None:
        if not self.over:
            self.over = True
            self._done(ending, STATUS[ending], result)


STATUS = {"preempted": 2, "succeeded": 3, "aborted": 4, "rejected": 5, "lost": 9}
"""actionlib's numbers of goals that have ended."""


class ActionClient:
    """The client of an action, one goal at a time."""

    def __init__(self, ros: Ros, name: str, type_: Any):
        self._ros, self._name, self._type = ros, name, type_
        self._goal: Goal | None = None

    def wait(self, timeout: float) -> bool:
        return self._ros.wait_for_server(self._name, timeout)

    def send(self, goal: Any, done: Callable[[str, int, Any], None], feedback: Callback) -> None:
        """Send a goal; `done(ending, status, result)` is called once; endings are those of `STATUS`."""
        self._goal = sent = Goal(goal, done, feedback)
        server = self._ros.actions.get(self._name)
        if server is not None:
            server.take(sent)
            return
        result = self._ros.made_up(f"action {self._name}", self._type.Result)
        threading.Thread(target=sent.end, args=("succeeded", result), daemon=True).start()

    def cancel(self) -> None:
        server = self._ros.actions.get(self._name)
        if self._goal is not None and not self._goal.over and server is not None:
            self._goal.canceled = True
            server.canceled(self._goal)


class ActionServer:
    """Serves one action, one goal at a time: a new goal preempts the one that is being worked on.

    It calls `execute` with each goal on a thread of its own, which has to call `end`.
    """

    def __init__(self, ros: Ros, name: str, execute: Callback, preempt: Callable[[], None]):
        self._ros, self._name, self._execute, self._preempt = ros, name, execute, preempt
        self._goals: queue.SimpleQueue[Goal] = queue.SimpleQueue()
        self._current: Goal | None = None
        self._lock = threading.Lock()

    def start(self) -> None:
        self._ros.actions[self._name] = self
        threading.Thread(target=self._work, name=f"smach-server {self._name}", daemon=True).start()

    def take(self, goal: Goal) -> None:
        """Work on a goal as soon as the one before it has ended."""
        with self._lock:
            self._goals.put(goal)
            # A goal that has its result is over, though its thread may not have come back from telling it.
            busy = self._current is not None and not self._current.over
        if busy:
            self._ask()

    def canceled(self, goal: Goal) -> None:
        with self._lock:
            current = goal is self._current
        if current:
            self._ask()

    def _ask(self) -> None:
        """Ask for the end of the goal; not on the caller's thread, since a machine may take its time to hear it."""
        threading.Thread(target=self._preempt, name=f"smach-preempt {self._name}", daemon=True).start()

    def _work(self) -> None:
        while not self._ros.is_shutdown():
            goal = self._goals.get()
            with self._lock:
                self._current = goal
                asked = goal.canceled or not self._goals.empty()
            goal.begin()
            if asked:
                self._ask()
            try:
                self._execute(goal.message)
            finally:
                self.end("aborted")  # nothing when it was ended, as it should be

    def feedback(self, message: object) -> None:
        if self._current is not None and not self._current.over:
            self._current.feedback(message)

    def end(self, ending: str, result: object = None) -> None:
        if self._current is not None:
            self._current.end(ending, result)


class Ros:
    """ROS within one process: what the program offers it finds, and what nobody does isn't there.

    For a dry run, `stand_in` gives values for what isn't there, of which `tell` is told: then services answer, actions
    succeed, topics speak, parameters are set, and waiting takes no time.
    """

    def __init__(self, stand_in: Callable[[str], Any] | None = None, tell: Callable[[str], object] = lambda text: None):
        self._stand_in, self._tell = stand_in, tell
        self._told: set[str] = set()
        self._hooks: list[Callable[[], None]] = []
        self._over = threading.Event()
        self._ahead = 0.0
        self._subscribers: defaultdict[str, list[queue.SimpleQueue[Any]]] = defaultdict(list)
        self._publishers: defaultdict[str, list[Any]] = defaultdict(list)
        self.services: dict[str, Callable[[Any], Any]] = {}
        self.actions: dict[str, ActionServer] = {}
        self.loggers: Sequence[Logger] = ()
        """Where info, warnings, debugging and errors go, in the order of `smach.set_loggers`; empty for nowhere new."""

    def made_up(self, what: str, type_: Any) -> Any:
        """Return a value that stands for what nobody gives, and tell of it; what it says of truth is yes."""
        if self._stand_in is None:
            raise ServiceFailedError(f"there is no {what}")
        if what not in self._told:
            self._told.add(what)
            self._tell(what)
        made = self._stand_in(what) if type_ is None else type_()
        said = getattr(type_, "_fields_and_field_types", None)
        for name, kind in said.items() if isinstance(said, dict) else ():
            if kind == "boolean":
                setattr(made, name, True)
        return made

    def is_shutdown(self) -> bool:
        return self._over.is_set()

    def on_shutdown(self, hook: Callable[[], None]) -> None:
        self._hooks.append(hook)

    def shut_down(self, reason: str = "") -> None:
        for hook in self._hooks:
            hook()
        self._over.set()

    def spin(self) -> None:
        """Wait for the shutdown; not in a dry run, which nobody shuts down."""
        if self._stand_in is None:
            self._over.wait()

    def close(self) -> None:
        self._over.set()

    def now(self) -> float:
        return time.time() + self._ahead

    def sleep(self, seconds: float) -> None:
        """Wait; less when ROS is shut down meanwhile."""
        if self._stand_in is None:
            self._over.wait(max(0.0, seconds))
        else:
            self._ahead += max(0.0, seconds)
            time.sleep(_MOMENT)  # others have their turn

    def parameter(self, name: str) -> Any:
        """Return a parameter that isn't set, in a dry run."""
        if self._stand_in is None:
            raise KeyError(f"{name}: set it, or give a file by GRIP_ROS_PARAMETERS or configure(parameters=...)")
        return self.made_up(f"parameter {name}", None)

    def name_of(self, name: str, node: object) -> str:
        """Return the full name of a topic, service or action as a node of the user's would have it."""
        return name if name.startswith("/") else f"/{name}"

    def subscribe(self, topic: str, type_: Any, callback: Callback) -> End:
        name, heard = self.name_of(topic, None), queue.SimpleQueue[Any]()
        over = threading.Event()
        patience = None if self._stand_in is None or type_ in vars(_MESSAGES).values() else _PERIOD

        def work() -> None:
            while not over.is_set():
                try:
                    message = heard.get(timeout=patience)
                except queue.Empty:
                    if self._publishers[name]:
                        continue
                    message = self.made_up(f"topic {name}", type_)
                if not over.is_set():
                    callback(message)

        def close() -> None:
            over.set()
            if heard in self._subscribers[name]:
                self._subscribers[name].remove(heard)
            heard.put(None)

        self._subscribers[name].append(heard)
        threading.Thread(target=work, name=f"subscriber {name}", daemon=True).start()
        return End(close)

    def advertise(self, topic: str, type_: Any) -> End:
        name = self.name_of(topic, None)
        self._publishers[name].append(type_)

        def publish(message: object) -> None:
            for heard in list(self._subscribers[name]):
                heard.put(message)

        def listeners() -> int:
            return len(self._subscribers[name]) or int(self._stand_in is not None)

        return End(lambda: self._publishers[name].remove(type_), publish, listeners)

    def topics_of(self, type_: Any) -> list[str]:
        return [name for name, types in list(self._publishers.items()) if type_ in types]

    def wait_for_server(self, name: str, timeout: float) -> bool:
        end = time.monotonic() + timeout
        while name not in self.services and name not in self.actions and self._stand_in is None:
            if time.monotonic() >= end or self._over.wait(_PERIOD / 10):
                return False
        return True

    def service(self, name: str, type_: Any) -> Service:
        return Service(self, self.name_of(name, None), type_)

    def serve(self, name: str, type_: Any, answer: Callable[[Any], Any]) -> End:
        full = self.name_of(name, None)
        self.services[full] = answer
        return End(partial(self.services.pop, full, None))

    def action_client(self, name: str, type_: Any) -> ActionClient:
        return ActionClient(self, self.name_of(name, None), type_)

    def action_server(self, name: str, type_: Any, execute: Callback, preempt: Callable[[], None]) -> ActionServer:
        return ActionServer(self, self.name_of(name, None), execute, preempt)

    def transform(
        self, target: str, source: str, at: float | None, timeout: float
    ) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
        """Return where a frame is in another, at a time [s] or last: x, y, z [m], and x, y, z, w; see NoFrameError."""
        if self._stand_in is None:
            raise NoFrameError(f"{source!r} isn't known in {target!r}")
        self.made_up(f"frame {source}", None)
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)

    def broadcast(
        self, parent: str, child: str, move: tuple[float, ...], turn: tuple[float, ...], stamp: float
    ) -> None:
        """Tell others where a frame is; nobody is there."""

    def introspection(self) -> SimpleNamespace:
        """Return the messages of smach_msgs as this ROS has them.

        `packed` and `unpacked` turn bytes into what the field `local_data` has, and back.
        """
        return _MESSAGES


_MESSAGES = SimpleNamespace(
    Status=type("SmachContainerStatus", (SimpleNamespace,), {}),
    Structure=type("SmachContainerStructure", (SimpleNamespace,), {}),
    InitialStatusCmd=type("SmachContainerInitialStatusCmd", (SimpleNamespace,), {}),
    header=lambda: None,
    packed=bytes,
    unpacked=bytes,
)
