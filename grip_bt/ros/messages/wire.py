"""Values of the stores as ROS messages in CDR, and as YAML that people read and change; and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

from grip_bt.base.failures import ExpectedError
from grip_bt.base.message_store import STANDARD
from grip_bt.base.message_store.text import text_of, value_of
from grip_bt.base.values import Grasp, JointState, Pose

from ..client.types import ConversionError, InterfaceType, Message, load_type, type_name
from ..convert import from_message, to_message
from ..convert_values import header, pose_from_message, pose_to_message
from ..interface import BadRequestError

PREFIX = "/grip/messages"
"""Name space of the services and of the topic `changes`."""
MESSAGES: dict[str, str] = {
    "joint_states": "sensor_msgs/msg/JointState",
    "poses": "geometry_msgs/msg/PoseStamped",
    "robot_poses": "grip_msgs/msg/RobotPose",
    "trajectories": "trajectory_msgs/msg/JointTrajectory",
    "plans": "grip_msgs/msg/Plan",
    "grasps": "grip_msgs/msg/Grasp",
    "clouds": "sensor_msgs/msg/PointCloud2",
    "images": "sensor_msgs/msg/Image",
}
"""ROS types of the standard stores."""
CHANGES = ("put", "deleted", "pushed", "taken")
"""Kinds of changes, in the order of their numbers."""
_POSTURES = ("pre_posture", "posture")
_LARGE = 100_000
"""From how many bytes on nobody reads a message as text."""


@dataclass(frozen=True, slots=True)
class RawMessage:
    """A message as it is sent: nothing of it is lost, whatever its type; `data`: CDR."""

    type: str
    data: bytes


def pack(store: str, value: object) -> RawMessage:
    """Return a value, or any message, as the store keeps it.

    Raises:
        BadRequestError: it can't be one; with the field that doesn't fit.
    """
    if isinstance(value, RawMessage):
        return value
    if hasattr(value, "get_fields_and_field_types"):
        return RawMessage(type_name(type(value)), bytes(serialize_message(value)))
    if store not in MESSAGES:
        raise BadRequestError(f"store {store!r}: a ROS message is expected, not a {type(value).__name__}")
    try:
        cls = load_type(MESSAGES[store])
        message = _robot_pose(cls, value) if store == "robot_poses" else to_message(value, cls)
    except ConversionError as error:
        raise BadRequestError(f"store {store!r}: {error}") from None
    return RawMessage(MESSAGES[store], bytes(serialize_message(message)))


def message_of(raw: RawMessage) -> Message:
    """Return a message from its CDR.

    Raises:
        BadRequestError: the bytes aren't one of this type.
        UnknownNameError, MissingPartError: there is no such type here.
    """
    cls = load_type(raw.type)
    try:
        return deserialize_message(raw.data, cls)
    except Exception as error:  # noqa: BLE001 - rclpy's own errors, which share no class
        raise BadRequestError(f"{len(raw.data)} bytes aren't a {raw.type} in CDR: {error}") from None


def unpack(store: str, raw: RawMessage) -> Any:
    """Return what a store keeps as the value of a standard store, else as the message itself.

    Raises:
        ConversionError: a standard store has something that can't be its value.
        BadRequestError: the bytes aren't a message of the type.
    """
    message = message_of(raw)
    if MESSAGES.get(store) != raw.type:
        return message
    if store == "robot_poses":
        frame = message.header.frame_id
        return {n: pose_from_message(p, frame) for n, p in zip(message.link_names, message.poses, strict=True)}
    if store == "grasps":
        return _grasp(message)
    return from_message(message, STANDARD[store])


def _robot_pose(cls: InterfaceType, value: object) -> Message:
    if not isinstance(value, Mapping) or not all(isinstance(pose, Pose) for pose in value.values()):
        raise ConversionError("", "a mapping from link names to poses is expected")
    frames = {pose.frame for pose in value.values()}
    if len(frames) != 1:
        raise ConversionError("", f"the poses of a robot pose are given in one frame, not in {sorted(frames)}")
    return cls(header=header(frames.pop()), link_names=list(value), poses=[pose_to_message(p) for p in value.values()])


def _grasp(message: Message) -> Grasp:
    said: dict[str, Any] = {}
    for name in message.get_fields_and_field_types():
        part = getattr(message, name)
        if name in _POSTURES:
            said[name] = from_message(part, JointState) if part.name else None
        else:
            said[name] = from_message(part, Pose) if name.endswith(("pose", "grasp")) else part
    return Grasp(**said)


def entry_rows(answer: Message) -> list[dict[str, Any]]:
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


def text_of_entry(store: str, raw: RawMessage) -> str:
    """Return what a store keeps as YAML: as a project's files have it, else field by field; empty for a big one."""
    if len(raw.data) > _LARGE:
        return ""
    with suppress(ConversionError):
        if text := text_of(unpack(store, raw)):
            return text
    return text_of(message_of(raw))


def value_from_text(
    store: str, name: str, text: str, type_: str = "", states: Callable[[], Mapping[str, JointState]] = dict
) -> Any:
    """Return what a text says: the value of a standard store, or a message.

    Args:
        text: YAML; see `grip_bt.base.message_store.text.value_of`.
        type_: the ROS type of its message, where the store isn't a standard one.
        states: asked for what the way-points of a trajectory can name.

    Raises:
        DocumentError: the text says something else, with the place.
        ExpectedError: nobody says of which type it is.
        UnknownNameError, MissingPartError: there is no such type here.
        ConversionError: a field isn't one of the type's, or has another type.
    """
    value = value_of(store, name, text, states() if store == "trajectories" else {})
    if not isinstance(value, dict) or store in ("poses", "joint_states", "robot_poses"):
        return value
    type_ = type_ or MESSAGES.get(store, "")
    if not type_:
        raise ExpectedError(f"store {store!r} is new: say the ROS type of its messages, such as std_msgs/msg/String")
    return to_message(value, load_type(type_))
