"""A ROS 1 that is one process: what legacy code and `smach_ros` use of rospy, with the master in this module.

Each subscriber has a queue and a thread, as in rospy, so that publishing never waits for a callback.
"""

import functools
import logging
import queue
import threading
import time
from types import SimpleNamespace

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
_log = logging.getLogger("standin.ros1")


class ROSException(Exception):
    pass


class ROSInterruptException(ROSException):
    pass


class ServiceException(Exception):
    pass


class Master:
    """Who is there."""

    def __init__(self):
        self.lock = threading.RLock()
        self.reset()

    def reset(self):
        self.publishers, self.subscribers, self.services, self.actions = [], [], {}, {}
        self.hooks, self.shutdown = [], threading.Event()


master = Master()


def resolved(name):
    return name if name.startswith("/") else f"/{name}"


@functools.total_ordering
class _Seconds:
    def __init__(self, secs=0, nsecs=0):
        self._nanoseconds = round(secs * 1e9) + nsecs

    def to_sec(self):
        return self._nanoseconds / 1e9

    def to_nsec(self):
        return self._nanoseconds

    def __eq__(self, other):
        return type(self) is type(other) and self._nanoseconds == other._nanoseconds

    def __lt__(self, other):
        if type(self) is not type(other):
            raise TypeError(f"{type(self).__name__} and {type(other).__name__} can't be compared")
        return self._nanoseconds < other._nanoseconds

    def __hash__(self):
        return hash(self._nanoseconds)

    def __bool__(self):
        return bool(self._nanoseconds)


class Duration(_Seconds):
    pass


class Time(_Seconds):
    @staticmethod
    def now():
        return Time(nsecs=time.time_ns())

    def __add__(self, duration):
        return Time(nsecs=self._nanoseconds + duration._nanoseconds)

    def __sub__(self, other):
        kind = Duration if isinstance(other, Time) else Time
        return kind(nsecs=self._nanoseconds - other._nanoseconds)


get_rostime = Time.now


def sleep(duration):
    seconds = duration.to_sec() if isinstance(duration, Duration) else duration
    if master.shutdown.wait(max(0.0, seconds)):
        raise ROSInterruptException("ROS shutdown request")


class Rate:
    def __init__(self, hz):
        self._period = 1.0 / hz

    def sleep(self):
        sleep(self._period)


def init_node(name, log_level=INFO, **options):
    logging.getLogger("standin.ros1").setLevel(logging.DEBUG if log_level == DEBUG else logging.INFO)


def is_shutdown():
    return master.shutdown.is_set()


def signal_shutdown(reason):
    for hook in list(master.hooks):
        hook()
    core._in_shutdown = True
    master.shutdown.set()


def spin():
    master.shutdown.wait()


core = SimpleNamespace(_in_shutdown=False, add_client_shutdown_hook=lambda hook: master.hooks.append(hook))


def _logger(level):
    return lambda text, *args, **kwargs: _log.log(level, text, *args)


logdebug, loginfo, logwarn = _logger(logging.DEBUG), _logger(logging.INFO), _logger(logging.WARNING)
logerr, logfatal = _logger(logging.ERROR), _logger(logging.CRITICAL)


class Publisher:
    def __init__(self, name, data_class, queue_size=None):
        self.name, self.type = resolved(name), data_class
        with master.lock:
            master.publishers.append(self)

    def publish(self, message):
        if not isinstance(message, self.type):
            raise ROSException(f"{self.name} takes {self.type.__name__}, not {type(message).__name__}")
        with master.lock:
            hearers = [s for s in master.subscribers if s.name == self.name]
        for hearer in hearers:
            hearer.queue.put(message)

    def unregister(self):
        with master.lock:
            master.publishers.remove(self)


class Subscriber:
    def __init__(self, name, data_class, callback, callback_args=None, queue_size=None):
        self.name, self.queue = resolved(name), queue.SimpleQueue()
        self._call = (lambda m: callback(m)) if callback_args is None else (lambda m: callback(m, callback_args))
        threading.Thread(target=self._deliver, name=f"standin {name}", daemon=True).start()
        with master.lock:
            master.subscribers.append(self)

    def _deliver(self):
        while (message := self.queue.get()) is not None:
            try:
                self._call(message)
            except Exception:  # noqa: BLE001 - as rospy: logged, and the next message comes
                _log.exception("bad callback on %s", self.name)

    def unregister(self):
        with master.lock:
            if self in master.subscribers:
                master.subscribers.remove(self)
        self.queue.put(None)


class Service:
    def __init__(self, name, service_class, handler):
        self.name = resolved(name)
        master.services[self.name] = (service_class, handler)

    def shutdown(self, reason=""):
        master.services.pop(self.name, None)


class ServiceProxy:
    def __init__(self, name, service_class):
        self._name, self._type = resolved(name), service_class

    def __call__(self, request):
        if self._name not in master.services:
            raise ServiceException(f"service [{self._name}] unavailable")
        _, handler = master.services[self._name]
        try:
            response = handler(request)
        except Exception as error:
            raise ServiceException(f"service [{self._name}] responded with an error: {error}") from error
        if response is None:
            raise ServiceException(f"service [{self._name}] returned no response")
        return response


def wait_for_service(service, timeout=None):
    deadline = time.monotonic() + (float("inf") if timeout is None else timeout)
    while resolved(service) not in master.services:
        if time.monotonic() > deadline:
            raise ROSException(f"timeout exceeded while waiting for service {service}")
        sleep(0.005)
