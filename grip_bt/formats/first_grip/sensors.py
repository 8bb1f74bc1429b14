"""Sensors of the first GRIP: topics by alias, a frame, and where it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from .configuration import Configuration
from .original import Note
from .words import key_of

_TYPES = (
    (("point", "cloud", "pc"), "PointCloud"),
    (("info",), "CameraInfo"),
    (("depth",), "DepthImage"),
    (("image", "rgb", "color", "colour"), "Image"),
    (("joint",), "JointState"),
)


def sensor_entry(name: str, said: Mapping[str, Any], found: Configuration) -> dict[str, Any] | None:
    """Return a sensor as `grip.yaml` has it; None where it has no topic."""
    given = said["data_topics"]
    topics = {}
    for alias, topic in given.items() if isinstance(given, dict) else ():
        type_name = _type(str(alias), str(topic))
        if type_name is None:
            text = f"what the topic {topic} carries isn't known: add it to `sensors`, with its type"
            found.notes.append(Note("missing", name, text))
            continue
        found.notes.append(Note("changed", name, f"{alias}: {type_name}, by the names of alias and topic"))
        topics[key_of(str(alias))] = {"topic": "/" + str(topic).strip("/"), "type": type_name}
    if not topics:
        return None
    made: dict[str, Any] = {"topics": topics}
    pose = said.get("initial_pose")
    pose = found.part("poses").get(pose) if isinstance(pose, str) else pose
    if said.get("frame_id") and isinstance(pose, dict):
        made["mount"] = _mount(name, str(said["frame_id"]), pose, found)
    elif said.get("initial_pose"):
        found.notes.append(Note("missing", name, f"where it is ({said['initial_pose']!r}) isn't known; add `mount`"))
    if said.get("launch_file"):
        found.notes.append(
            Note("missing", name, f"{said['launch_file']} is of ROS 1: start its ROS 2 driver, or `driver`")
        )
    return {key: value for key, value in made.items() if value}


def _type(alias: str, topic: str) -> str | None:
    for text in (alias.lower(), topic.lower()):
        for words, type_name in _TYPES:
            if any(word in text for word in words):
                return type_name
    return None


def _mount(name: str, frame: str, pose: Mapping[str, Any], found: Configuration) -> dict[str, Any] | None:
    try:
        position = [float(pose["position"][axis]) for axis in "xyz"]
        turn = pose["orientation"]
        if "w" in turn:
            quaternion = [float(turn[axis]) for axis in "wxyz"]
        else:
            quaternion = quaternion_of(*(float(turn[axis]) for axis in "rpy"))
    except (KeyError, TypeError, ValueError) as error:
        found.notes.append(Note("missing", name, f"its pose can't be read ({error}); add `mount`"))
        return None
    return {
        "frame": frame,
        "on": str(pose.get("reference_frame", "world")),
        "position": position,
        "quaternion": quaternion,
    }


def quaternion_of(roll: float, pitch: float, yaw: float) -> list[float]:
    """Return w, x, y, z of turns about the fixed x, then y, then z axis [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(angle / 2), math.sin(angle / 2)) for angle in (roll, pitch, yaw))
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
