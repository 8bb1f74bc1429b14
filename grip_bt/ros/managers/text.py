"""What a server of messages has, as plain data and as YAML that people read and change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.base.failures import ExpectedError
from grip_bt.base.message_store.written import plain_of, text_of, value_of
from grip_bt.base.values import JointState

from ..convert import to_message
from ..types import load_type
from .wire import MESSAGES, message_of, pack, unpack


def entry_rows(answer: Any) -> list[dict[str, Any]]:
    """Return the entries of an answer to `list` as plain data; `time` in seconds of the Unix epoch."""
    return [
        {
            "store": entry.store,
            "name": entry.name,
            "type": entry.type,
            "time": entry.stamp.sec + entry.stamp.nanosec * 1e-9,
            "provenance": entry.provenance,
            "revision": entry.revision,
        }
        for entry in answer.entries
    ]


def text_of_entry(store: str, value: Any) -> str:
    """Return a value of a store as YAML: as a project's files have it, else field by field; empty for a big one."""
    return text_of(value) or text_of(message_of(pack(store, value)))


def text_of_message(store: str, message: Any) -> str:
    """Return a message of a store likewise."""
    return text_of_entry(store, unpack(store, pack(store, message)))


def plain_of_entry(store: str, value: Any) -> Any:
    """Return the fields of a value's message as plain data, None for a big one."""
    return plain_of(message_of(pack(store, value)))


def value_from_text(
    store: str, name: str, text: str, type_: str = "", states: Mapping[str, JointState] | None = None
) -> Any:
    """Return what a text says: the value of a standard store, or a message.

    Args:
        store: where it goes.
        name: of the value, for messages.
        text: YAML; see `grip_bt.base.message_store.written.value_of`.
        type_: the ROS type of its message, where the store isn't a standard one.
        states: what the way-points of a trajectory can name.

    Raises:
        DocumentError: the text says something else, with the place.
        ExpectedError: nobody says of which type it is.
        UnknownNameError, MissingPartError: there is no such type here.
        ConversionError: a field isn't one of the type's, or has another type.
    """
    value = value_of(store, name, text, states)
    if not isinstance(value, dict) or store in ("poses", "joint_states", "robot_poses"):
        return value
    type_ = type_ or MESSAGES.get(store, "")
    if not type_:
        raise ExpectedError(f"store {store!r} is new: say the ROS type of its messages, such as std_msgs/msg/String")
    return to_message(value, load_type(type_))
