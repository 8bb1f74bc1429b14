"""Message and interface types by name."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from grip_bt.errors import MissingPartError, UnknownNameError


@cache
def load_type(name: str) -> Any:
    """Return the class of a type such as `sensor_msgs/msg/PointCloud2` or `std_srvs/srv/Trigger`.

    Raises:
        UnknownNameError: its package has no such type.
        MissingPartError: its package isn't importable.
    """
    parts = name.split("/")
    if len(parts) == 2:
        parts.insert(1, "msg")
    if len(parts) != 3:
        raise UnknownNameError("ROS type", name, ("package/msg/Name", "package/srv/Name", "package/action/Name"))
    package, kind, cls = parts
    try:
        module = import_module(f"{package}.{kind}")
    except ImportError as error:
        raise MissingPartError(f"the interface package {package!r} ({error})", "grip interfaces build FOLDER") from None
    try:
        return getattr(module, cls)
    except AttributeError:
        known = [n for n in vars(module) if n[0].isupper()]
        raise UnknownNameError("ROS type", name, (f"{package}/{kind}/{n}" for n in known)) from None


def type_name(cls: Any) -> str:
    """Return the name of a type's class, such as `std_srvs/srv/Trigger`."""
    package, kind = cls.__module__.split(".")[:2]
    return f"{package}/{kind}/{cls.__name__}"
