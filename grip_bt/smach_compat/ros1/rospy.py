"""`rospy` over ROS 2: logs, time, names, topics, services; parameters are kept in this process.

ROS 2 has no server of parameters: `set_param` and the file of the setting `parameters` say what they are.
"""

from __future__ import annotations

import importlib
import os
import queue
import sys
import threading
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.smach_compat._settings import hooks, settings
from grip_bt.smach_compat.smach_ros._connection import fields, ros, seconds, stands_in
from grip_bt.smach_compat.smach_ros._port import ServiceFailedError

from . import Duration as Duration
from . import Time as Time
from . import now as get_rostime

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16


def __getattr__(name: str) -> Any:
    if name != "Header":  # of messages, which nothing else here needs
        raise AttributeError(f"module 'rospy' has no attribute {name!r}")
    return importlib.import_module("std_msgs.msg").Header


SLICE = 1.0
"""How often a wait without end looks whether ROS was shut down [s]."""


class ROSException(Exception):
    """Something of ROS failed, or took too long."""


class ROSInterruptException(ROSException):
    """ROS is being shut down."""


class ROSInitException(ROSException):
    """A node can't begin."""


class ServiceException(Exception):
    """A service gave no answer."""


def _logger(name: str) -> Callable[..., None]:
    def log(msg: object, *args: object, **_: object) -> None:
        getattr(hooks, name)(str(msg) % args if args else msg)

    return log


_said: dict[Any, float] = {}


def _now_and_then(log: Callable[..., None], once: bool = False) -> Callable[..., None]:
    def throttled(*given: Any, **_: object) -> None:
        period, *message = (float("inf"), *given) if once else given
        caller = sys._getframe(1)
        place, time = (caller.f_code, caller.f_lineno), ros().now()
        if place not in _said or time - _said[place] >= period:
            _said[place] = time
            log(*message)

    return throttled


logdebug, loginfo, logwarn, logerr = map(_logger, ("logdebug", "loginfo", "logwarn", "logerr"))
logfatal = logerr
for _name in ("logdebug", "loginfo", "logwarn", "logerr", "logfatal"):
    globals()[f"{_name}_throttle"] = globals()[f"{_name}_throttle_identical"] = _now_and_then(globals()[_name])
    globals()[f"{_name}_once"] = _now_and_then(globals()[_name], once=True)
log_warning, logerror = logwarn, logerr

_node = SimpleNamespace(name="/unnamed", ready=False)


def init_node(name: str, argv: object = None, anonymous: bool = False, **_: object) -> None:
    """Give the node its name; it is on the network from the first topic, service or action on."""
    _node.name, _node.ready = "/" + name.strip("/") + (f"_{uuid.uuid4().hex[:8]}" if anonymous else ""), True


def get_name() -> str:
    return str(_node.name)


get_caller_id = get_name


def get_namespace() -> str:
    """Return the name space, which is always `/`."""
    return "/"


def resolve_name(name: str, caller_id: str | None = None) -> str:
    """Return a name in full: `~x` is the node's own."""
    if name.startswith("~"):
        return f"{caller_id or get_name()}/{name[1:].strip('/')}"
    return name if name.startswith("/") else f"/{name}"


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return the arguments of the command line that aren't ROS's."""
    return [each for each in (sys.argv if argv is None else argv) if ":=" not in each]


def is_shutdown() -> bool:
    return ros().is_shutdown()


def signal_shutdown(reason: object = "") -> None:
    ros().shut_down(str(reason))


def on_shutdown(h: Callable[[], None]) -> None:
    ros().on_shutdown(h)


def spin() -> None:
    ros().spin()


def is_initialized() -> bool:
    return bool(_node.ready)


core = exceptions = rostime = service = sys.modules[__name__]
"""Its sub-modules are itself."""


def get_time() -> float:
    return ros().now()


def sleep(duration: Any) -> None:
    ros().sleep(seconds(duration))
    if ros().is_shutdown():
        raise ROSInterruptException("ROS is being shut down")


class Rate:
    """Lets a loop run at a rate [Hz]."""

    def __init__(self, hz: float, reset: bool = False):
        self.sleep_dur = Duration(1.0 / hz)
        self._next: float | None = None

    def remaining(self, curr_time: Any = None) -> Any:
        return Duration(0.0 if self._next is None else max(0.0, self._next - get_time()))

    def sleep(self) -> None:
        period, time = self.sleep_dur.to_sec(), get_time()
        due = time + period if self._next is None or time - self._next > period else self._next
        self._next = due + period
        sleep(max(0.0, due - time))


class Timer(threading.Thread):
    """Calls a function periodically, with an event that has the times."""

    def __init__(self, period: Any, callback: Callable[[Any], object], oneshot: bool = False, reset: bool = False):
        super().__init__(daemon=True)
        self._period, self._callback, self._oneshot = seconds(period), callback, oneshot
        self._over = threading.Event()
        self.start()

    def shutdown(self) -> None:
        self._over.set()

    def run(self) -> None:
        last = None
        while not self._over.is_set():
            expected = get_rostime() + Duration(self._period)
            ros().sleep(self._period)
            if self._over.is_set() or is_shutdown():
                return
            real = get_rostime()
            self._callback(
                SimpleNamespace(last_expected=None, last_real=last, current_expected=expected, current_real=real)
            )
            last = real
            if self._oneshot:
                return


_parameters: dict[str, Any] = {}
_lock = threading.RLock()


def _known() -> dict[str, Any]:
    file = settings.parameters or os.environ.get("GRIP_ROS_PARAMETERS", "")
    if file and _node.__dict__.get("file") != file:
        _node.file = file
        said = to_data(parse(read_file(Path(file)), file))
        _parameters.update(said if isinstance(said, dict) else {})
    return _parameters


def _place(name: str) -> list[str]:
    return [part for part in resolve_name(name).split("/") if part]


_MISSING: Any = object()


def get_param(param_name: str, default: Any = _MISSING) -> Any:
    with _lock:
        found: Any = _known()
        for part in _place(param_name):
            if not isinstance(found, dict) or part not in found:
                if default is _MISSING:
                    return ros().parameter(resolve_name(param_name))
                return default
            found = found[part]
        return found


get_param_cached = get_param


def has_param(param_name: str) -> bool:
    return get_param(param_name, _lock) is not _lock


def set_param(param_name: str, param_value: object) -> None:
    """Set a parameter, for this process."""
    with _lock:
        at = _known()
        *above, last = _place(param_name)
        for part in above:
            at = at.setdefault(part, {})
        at[last] = param_value


def delete_param(param_name: str) -> None:
    with _lock:
        *above, last = _place(param_name)
        del (get_param("/" + "/".join(above)) if above else _known())[last]


def _message(type_: Any, values: tuple[Any, ...], named: dict[str, Any]) -> Any:
    if len(values) == 1 and not named and (stands_in(values[0]) or isinstance(values[0], type_) or not fields(type_())):
        return values[0]
    return type_(*values, **named)


class Publisher:
    """Sends on a topic."""

    def __init__(self, name: str, data_class: Any, *_: object, **__: object):
        self.name = self.resolved_name = resolve_name(name)
        self.data_class = self.type = data_class
        self._end = ros().advertise(self.name, data_class)

    def publish(self, *args: Any, **kwds: Any) -> None:
        self._end.publish(_message(self.data_class, args, kwds))

    def get_num_connections(self) -> int:
        return self._end.listeners()

    def unregister(self) -> None:
        self._end.close()


class Subscriber:
    """Has a function called with each message of a topic."""

    def __init__(
        self, name: str, data_class: Any, callback: Any = None, callback_args: Any = None, *_: object, **__: object
    ):
        self.name = self.resolved_name = resolve_name(name)
        self.data_class = self.type = data_class
        self._callback, self._args = callback, () if callback_args is None else (callback_args,)
        self._end = ros().subscribe(self.name, data_class, self._hear)

    def _hear(self, message: Any) -> None:
        if self._callback is None:
            return
        try:
            self._callback(message, *self._args)
        except Exception as error:  # noqa: BLE001 - as rospy: logged, and the next message comes
            logerr(f"bad callback of {self.name}: {error!r}")

    def unregister(self) -> None:
        self._end.close()


def wait_for_message(topic: str, topic_type: Any, timeout: Any = None) -> Any:
    came: queue.SimpleQueue[Any] = queue.SimpleQueue()
    end = ros().subscribe(resolve_name(topic), topic_type, came.put)
    heard: list[Any] = []

    def wait(left: float) -> bool:
        with suppress(queue.Empty):
            heard.append(came.get(timeout=left))
        return bool(heard)

    try:
        _until(wait, timeout, f"timeout exceeded while waiting for message on topic {resolve_name(topic)}")
    finally:
        end.close()
    return heard[0]


def _until(wait: Callable[[float], bool], timeout: Any, words: str) -> None:
    if not waited(wait, float("inf") if timeout is None else seconds(timeout)):
        if is_shutdown():
            raise ROSInterruptException("ROS is being shut down")
        raise ROSException(words)


def waited(wait: Callable[[float], bool], left: float) -> bool:
    """Tell whether something comes in time [s], before ROS is shut down."""
    while not wait(min(left, SLICE)):
        left -= SLICE
        if left <= 0 or is_shutdown():
            return False
    return True


class ServiceProxy:
    """Calls a service."""

    def __init__(self, name: str, service_class: Any, *_: object, **__: object):
        self.resolved_name, self.service_class = resolve_name(name), service_class
        self.request_class = service_class.Request
        self._client = ros().service(self.resolved_name, service_class)

    def __call__(self, *args: Any, **kwds: Any) -> Any:
        try:
            if not self._client.wait(0.0):
                raise ServiceException(f"service [{self.resolved_name}] unavailable")
            return self._client.call(_message(self.request_class, args, kwds))
        except ServiceFailedError as error:
            raise ServiceException(str(error)) from error

    call = __call__

    def wait_for_service(self, timeout: Any = None) -> None:
        _until(self._client.wait, timeout, f"timeout exceeded while waiting for service {self.resolved_name}")

    def close(self) -> None:
        """Do nothing; a client costs little."""


def wait_for_service(service: str, timeout: Any = None) -> None:
    """Wait until somebody serves a service, of whatever type."""
    name = resolve_name(service)
    _until(
        lambda left: ros().wait_for_server(name, left), timeout, f"timeout exceeded while waiting for service {name}"
    )


class Service:
    """Serves a service."""

    def __init__(self, name: str, service_class: Any, handler: Callable[[Any], Any], *_: object, **__: object):
        self.resolved_name, self._response = resolve_name(name), service_class.Response
        self._handler = handler
        self._end = ros().serve(self.resolved_name, service_class, self._answer)

    def _answer(self, request: Any) -> Any:
        answer = self._handler(request)
        if isinstance(answer, dict):
            return self._response(**answer)
        return _message(self._response, tuple(answer) if isinstance(answer, (list, tuple)) else (answer,), {})

    def shutdown(self, reason: str = "") -> None:
        self._end.close()

    def spin(self) -> None:
        spin()
