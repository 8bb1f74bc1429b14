"""XML files of robots, and xacro."""

from __future__ import annotations

import json
import math
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

from grip_bt.base.errors import DocumentError, listing
from grip_bt.base.interpreter import python_command
from grip_bt.base.values.pose import Pose, quaternion_of
from grip_bt.base.xml import XmlElement, parse_xml

from .file_cache import note
from .packages import Packages

LARGEST = 64 * 1024 * 1024
"""Bytes; the largest robots have about one million."""


def line_of(element: ET.Element) -> int | None:
    """Return the 1-based line on which an element starts, where it was read from a file."""
    return getattr(element, "line", None)


def read_xml(path: Path, root: str) -> XmlElement:
    """Read a file whose outermost element is `root`.

    Raises:
        DocumentError: it isn't there, isn't well-formed, declares entities, or has another root.
    """
    note(path)
    if not path.is_file():
        raise DocumentError("there is no such file", str(path))
    if path.stat().st_size > LARGEST:
        raise DocumentError(f"it has more than {LARGEST // 2**20} MiB: that isn't a robot's description", str(path))
    text = path.read_bytes()
    if (begin := text.find(b"<?xml")) > 0:  # below a licence; ROS's parsers don't mind
        end = text.find(b"?>", begin) + 2
        text = text[:begin] + b" " * (end - begin) + text[end:]
    return _rooted(text, root, str(path))


def _rooted(text: bytes | str, root: str, source: str) -> XmlElement:
    element = parse_xml(text, source)
    if element.tag != root:
        raise DocumentError(f"its outermost element has to be <{root}>, not <{element.tag}>", source, element.line)
    return element


def numbers(element: ET.Element, attribute: str, count: int, default: str, source: str = "") -> tuple[float, ...]:
    """Return an attribute as finite numbers, of a given count. Raises DocumentError: it isn't that."""
    text = element.get(attribute, default)
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise DocumentError(
            f"{attribute}={text!r} of <{element.tag}> has to be {wanted}", source, line_of(element)
        ) from None
    return values


def origin_of(element: ET.Element, frame: str = "world") -> Pose:
    """Return where an element's `origin` puts it, as URDF has it: angles about fixed axes."""
    given = {} if (found := element.find("origin")) is None else found.attrib
    xyz, rpy = ([float(v) for v in given.get(key, "0 0 0").split()] for key in ("xyz", "rpy"))
    return Pose(xyz, quaternion_of(*rpy), frame)


def required(element: ET.Element, attribute: str, source: str = "") -> str:
    """Return an attribute that mustn't be missing or empty. Raises DocumentError: it is."""
    value = element.get(attribute, "").strip()
    if not value:
        has = listing(element.keys(), "none at all")
        raise DocumentError(
            f"<{element.tag}> needs the attribute {attribute!r} (it has: {has})", source, line_of(element)
        )
    return value


TIME = 30.0
"""A file that takes longer never ends [s]; large robots take one or two."""
MODULE = "grip_bt.commanders.description.xacro_process"


def expand(path: Path, arguments: Mapping[str, object], packages: Packages) -> tuple[str, tuple[str, ...]]:
    """Return a xacro file's XML, and what was left out of it since packages that it includes from aren't here.

    Args:
        arguments: values for its `<xacro:arg>`s; those that it doesn't declare are passed too, for files it includes.
        packages: for `$(find NAME)`.

    Raises:
        DocumentError: it can't be expanded; the message is xacro's own.
    """
    if not path.is_file():
        raise DocumentError("there is no such file", str(path))
    request = {
        "file": str(path.absolute()),
        "arguments": {
            name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in arguments.items()
        },
        "packages": {name: str(folder) for name, folder in packages.given.items()},
    }
    try:
        done = subprocess.run(
            python_command("-m", MODULE), input=json.dumps(request), capture_output=True, text=True, timeout=TIME
        )
        reply = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise DocumentError(f"xacro doesn't end: it was stopped after {TIME:g} s", str(path)) from None
    except json.JSONDecodeError:
        raise DocumentError("xacro ended without a result: it took too much time or memory", str(path)) from None
    if "error" in reply:
        raise DocumentError(f"xacro: {reply['error']}", str(path))
    note(*map(Path, reply["files"]))
    return str(reply["text"]), tuple(reply["left"])


def read_robot(path: Path, arguments: Mapping[str, object], packages: Packages) -> XmlElement:
    """Return a URDF or SRDF, or a xacro file of one, as its tree; lines are those of the expanded text.

    Raises:
        DocumentError: it can't be read or expanded, or is something else.
    """
    if path.suffix != ".xacro":
        return read_xml(path, "robot")
    text, left = expand(path, arguments, packages)
    robot = _rooted(text, "robot", str(path))
    robot.left_out = left  # type: ignore[attr-defined]  # told by whoever describes the robot
    return robot
