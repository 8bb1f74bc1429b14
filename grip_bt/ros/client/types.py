"""Message and interface types by name."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from rclpy.exceptions import InvalidTopicNameException
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_topic_name import validate_topic_name

from grip_bt.base.errors import GripError, MissingPartError, UnknownNameError

from ..interfaces.ament import package_like, search_path


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
        absent = isinstance(error, ModuleNotFoundError) and error.name == package
        why = package_like(package, search_path()) if absent else str(error)
        what = f"the interface package {package!r} of {name}{why and f' ({why})'}"
        raise MissingPartError(what, "grip interfaces build FOLDER") from None
    try:
        return getattr(module, cls)
    except AttributeError:
        known = [n for n in vars(module) if n[0].isupper()]
        raise UnknownNameError("ROS type", name, (f"{package}/{kind}/{n}" for n in known)) from None


def load_message(name: str) -> Any:
    """Return the class of a message, as topics carry them.

    Raises:
        GripError: it is of a service or an action, or there is no such type; see `load_type`.
    """
    if name.count("/") == 2 and name.split("/")[1] != "msg":
        raise GripError(f"{name!r} is no message: a topic has a type such as 'sensor_msgs/msg/JointState'")
    return load_type(name)


def check_name(name: str) -> None:
    """Check the name of a topic, a service or an action.

    Raises:
        GripError: ROS knows no such names; it says which it knows.
    """
    try:
        validate_topic_name(name)
        if not name.startswith("~") and "{" not in name:  # only this check sees two slashes in a row
            validate_full_topic_name("/" + name.removeprefix("/"))
    except InvalidTopicNameException:
        allowed = "letters, digits and underscores between slashes, no digit first, such as /camera/image_raw"
        raise GripError(f"{name!r} can't name a topic, a service or an action: {allowed}") from None


def type_name(cls: Any) -> str:
    """Return the name of a type's class, such as `std_srvs/srv/Trigger`."""
    package, kind = cls.__module__.split(".")[:2]
    return f"{package}/{kind}/{cls.__name__}"
