"""What legacy programs import of ROS 1, over the same connection as `smach_ros`: `rospy`, `roslib`, `actionlib`, `tf`.

Services, topics, actions and frames are those of ROS 2. What ROS 2 has no equal of is kept in the process: parameters.
The package itself is `roslib`. Modules of ROS 2's messages get their names and constructors of ROS 1 when they are
imported: `std_srvs.srv.EmptyRequest`, `nav_msgs.msg.SomethingGoal`, `Point(1, 2, 3)`.
"""

from __future__ import annotations

import functools
import importlib
import numbers
import sys
from dataclasses import dataclass
from functools import partial
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from grip_bt.smach_compat._provided import Provided
from grip_bt.smach_compat._settings import settings
from grip_bt.smach_compat.smach_ros._connection import ros, stands_in

_PARTS = ("Goal", "Result", "Feedback")


class Ros1Names(MetaPathFinder, Loader):
    """Gives modules of messages their names of ROS 1 when they are imported; in `msg` are those of actions too."""

    def find_spec(self, fullname: str, path: Any = None, target: object = None) -> ModuleSpec | None:
        """Find a module `PACKAGE.msg` or `PACKAGE.srv` as Python does."""
        package, _, kind = fullname.rpartition(".")
        if kind not in ("msg", "srv") or not package or "." in package:
            return None
        spec = PathFinder.find_spec(fullname, path)
        if spec is None and kind == "msg" and PathFinder.find_spec(f"{package}.action", path) is not None:
            return ModuleSpec(fullname, self)
        if spec is not None and spec.loader is not None and hasattr(spec.loader, "exec_module"):
            execute = spec.loader.exec_module

            def executed(module: ModuleType) -> None:
                execute(module)
                give_names(module)

            spec.loader.exec_module = executed  # type: ignore[method-assign]
        return spec

    def create_module(self, spec: ModuleSpec) -> None:
        """Have the usual kind of module made, for a package that has no messages but those of its actions."""

    def exec_module(self, module: ModuleType) -> None:
        give_names(module)


def give_names(module: ModuleType) -> None:
    """Add the names of ROS 1 to a module of messages or services; nothing to any other."""
    package, _, kind = module.__name__.rpartition(".")
    for name, made in list(vars(module).items()):
        if not isinstance(made, type):
            continue
        if hasattr(made, "get_fields_and_field_types"):
            _by_position(made)
        elif kind == "srv" and hasattr(made, "Request"):
            for part in ("Request", "Response"):
                setattr(module, f"{name}{part}", _by_position(getattr(made, part)))
    if kind == "msg":
        _give_actions(module, package)


def _give_actions(module: ModuleType, package: str) -> None:
    try:
        actions = importlib.import_module(f"{package}.action")
    except ImportError:
        return
    for name, made in list(vars(actions).items()):
        if isinstance(made, type) and hasattr(made, "Goal"):
            setattr(module, f"{name}Action", made)
            for part in _PARTS:
                setattr(module, f"{name}{part}", _by_position(getattr(made, part)))


def _by_position(message: Any) -> Any:
    """Let fields be given by position too, as ROS 1 does, all or none of them; and whole numbers as floats."""
    begun = message.__init__
    if hasattr(begun, "__wrapped__"):
        return message  # done before, or a time

    @functools.wraps(begun)
    def init(self: Any, *values: Any, **fields: Any) -> None:
        names = list(message.get_fields_and_field_types()) if values else []
        if len(values) != len(names):
            raise TypeError(
                f"{message.__name__} takes {len(names)} fields by position or none, not {len(values)}: {names}"
            )
        begun(self, **dict(zip(names, values, strict=True)), **fields)

    kinds, keep = message.get_fields_and_field_types(), message.__setattr__
    message.__init__ = init
    message.__setattr__ = lambda self, name, value: keep(self, name, _as_field(kinds.get(name, ""), value))
    return message


_NUMBERS: dict[str, Any] = {"float": float, "double": float}
_NUMBERS |= {f"{sign}int{bits}": int for sign in ("", "u") for bits in (8, 16, 32, 64)}


def _as_field(kind: str, value: Any) -> Any:
    """Return what a field is given as ROS 2 takes it; a stand-in as what a field has at first, or as its number."""
    number = _NUMBERS.get(kind)
    if stands_in(value):
        return number(value) if number is not None else _at_first(kind) if kind else value
    wanted = numbers.Real if number is float else numbers.Integral
    return number(value) if number is not None and isinstance(value, wanted) else value


def _at_first(kind: str) -> Any:
    """Return the value that a field of a kind, as messages spell it, has at first."""
    item, _, size = kind.removesuffix("]").partition("[")
    if size:
        return [_at_first(item) for _ in range(int(size))]
    if "/" in kind and "<" not in kind:
        package, name = kind.split("/")
        return getattr(importlib.import_module(f"{package}.msg"), name)()
    plain = {"boolean": True, "octet": b"\0", "float": 0.0, "double": 0.0}
    return [] if "<" in kind and "sequence" in kind else "" if "string" in kind else plain.get(kind, 0)


_SECOND = 10**9


@dataclass
class _Whole:
    """Seconds and nanoseconds as in the messages: the latter are never negative."""

    sec: int = 0
    nanosec: int = 0


class _Reckoned:
    """What both have."""

    sec: int
    nanosec: int

    def to_nsec(self) -> int:
        return self.sec * _SECOND + self.nanosec

    def to_sec(self) -> float:
        return self.to_nsec() / _SECOND

    def is_zero(self) -> bool:
        return self.to_nsec() == 0

    def __lt__(self, other: Any) -> bool:
        if type(self) is not type(other):
            raise TypeError(f"{type(self).__name__} and {type(other).__name__} can't be compared")
        return bool(self.to_nsec() < other.to_nsec())

    def __hash__(self) -> int:
        return hash(self.to_nsec())


class _TimeOfRos1(_Reckoned):
    to_time = _Reckoned.to_sec

    def __add__(self, duration: Any) -> Any:
        return Time(0, self.to_nsec() + duration.to_nsec())

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return (Duration if isinstance(other, Time) else Time)(0, self.to_nsec() - other.to_nsec())


class _DurationOfRos1(_Reckoned):
    def __add__(self, other: Any) -> Any:
        return type(other)(0, self.to_nsec() + other.to_nsec())

    def __sub__(self, other: Any) -> Any:
        return Duration(0, self.to_nsec() - other.to_nsec())

    def __mul__(self, factor: float) -> Any:
        return Duration(0, round(self.to_nsec() * factor))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self.to_nsec() / other.to_nsec() if isinstance(other, Duration) else self * (1 / other)

    def __neg__(self) -> Any:
        return self * -1

    def __abs__(self) -> Any:
        return Duration(0, abs(self.to_nsec()))


def _class(name: str, more: type) -> Any:
    try:
        made: Any = getattr(importlib.import_module("builtin_interfaces.msg"), name)
    except ImportError:
        made = type(name, (_Whole,), {})
    begun = made.__init__

    @functools.wraps(begun)
    def init(self: Any, secs: float = 0, nsecs: int = 0, **fields: Any) -> None:
        sec, nanosec = divmod(round(secs * _SECOND) + nsecs, _SECOND)
        begun(self, **(fields or {"sec": sec, "nanosec": nanosec}))

    for each in (_Reckoned, more):
        for key, value in vars(each).items():
            if key not in ("__dict__", "__weakref__", "__module__", "__doc__", "__annotations__"):
                setattr(made, key, value)
    made.__init__ = init
    made.secs, made.nsecs = property(lambda self: self.sec), property(lambda self: self.nanosec)
    made.from_sec = made.from_seconds = staticmethod(lambda seconds: made(seconds))
    return functools.total_ordering(made)


Time = _class("Time", _TimeOfRos1)
Duration = _class("Duration", _DurationOfRos1)


def now() -> Any:
    return Time(ros().now())


Time.now = staticmethod(now)


_MODULES = {
    "rospy": ("", ".core", ".exceptions", ".rostime", ".service", ".timer", ".topics", ".client"),
    "actionlib": ("", ".simple_action_client", ".simple_action_server"),
    "tf": ("", ".listener", ".broadcaster", ".transformations"),
}
"""Module -> the names below it under which programs import it too."""


def _module(name: str) -> ModuleType:
    settings.rospy = True  # from the first import of one of them, and not in programs that import none
    return importlib.import_module(f"{__name__}.{name}" if name else __name__)


_PROVIDED = Provided(
    {f"{name}{below}": partial(_module, name) for name, all_below in _MODULES.items() for below in all_below}
    | {name: partial(_module, "") for name in ("roslib", "roslib.packages")}
)


def begin() -> None:
    """Have them found where no others are, and all messages their names of ROS 1, those that are there already too."""
    _PROVIDED.begin()
    if not any(isinstance(finder, Ros1Names) for finder in sys.meta_path):
        sys.meta_path.insert(0, Ros1Names())
        for name, module in list(sys.modules.items()):
            if name.count(".") == 1 and name.endswith((".msg", ".srv")) and isinstance(module, ModuleType):
                give_names(module)


def end() -> None:
    """Have them found no more."""
    _PROVIDED.end()
    sys.meta_path[:] = [finder for finder in sys.meta_path if not isinstance(finder, Ros1Names)]


packages = sys.modules[__name__]


class InvalidROSPkgException(Exception):
    """A package isn't there."""


def load_manifest(package_name: str) -> None:
    """Do nothing; of ROS 1 it put a package's Python on the path."""


def get_pkg_dir(package: str, required: bool = True) -> str | None:
    """Return the folder of a package, found by its `package.xml` around the folders that Python looks in.

    Raises:
        InvalidROSPkgException: it isn't there, and `required`.
    """
    for entry in dict.fromkeys(sys.path):
        here = Path(entry).resolve()
        for folder in (here, *here.parents[:3]):
            for found in (folder, folder / package, folder / "src" / package, folder / "share" / package):
                if found.name == package and (found / "package.xml").is_file():
                    return str(found)
    if required:
        raise InvalidROSPkgException(f"there is no package {package!r} around sys.path")
    return None
