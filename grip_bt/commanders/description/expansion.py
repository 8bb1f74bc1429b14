"""Xacro files as XML: expanded by the `xacro` package in a process with limits, and what they declare."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError, MissingPartError
from grip_bt.base.interpreter import python_command

from .files import note
from .packages import Packages
from .xml import Element, parse_xml, read_xml

TIME = 30.0
"""After so long a file won't end any more [s]; large robots take one or two."""
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


def read_robot(path: Path, arguments: Mapping[str, object], packages: Packages) -> Element:
    """Return a URDF or SRDF, or a xacro file of one, as its tree; lines are those of the expanded text.

    Raises:
        DocumentError: it can't be read or expanded, or is something else.
    """
    if path.suffix != ".xacro":
        return read_xml(path, "robot")
    text, left = expand(path, arguments, packages)
    robot = parse_xml(text, "robot", str(path))
    robot.left_out = left
    return robot


@dataclass(frozen=True)
class Declared:
    """What a xacro file says of itself before it is expanded.

    Attributes:
        arguments: those that it declares or uses, in order: name -> default, or None.
        choices: argument -> values for which a file is there that `$(find NAME)/.../$(arg ARGUMENT)...` names.
        whole: whether it holds a robot; else only macros for others.
    """

    arguments: Mapping[str, str | None]
    choices: Mapping[str, list[str]]
    whole: bool = True


_BY_ARGUMENT = re.compile(r"\$\(find ([\w-]+)\)((?:/[\w.-]+)*)/([\w.-]*)\$\(arg (\w+)\)([\w./-]*)")
_USED, _COMMENT = re.compile(r"\$\(arg (\w+)\)"), re.compile(r"<!--.*?-->", re.DOTALL)
_ASIDE = ("xacro:include", "xacro:arg", "xacro:property", "xacro:macro")


def declared(path: Path, packages: Packages) -> Declared:
    """Return it; nothing of a file that can't be read."""
    try:
        root = read_xml(path, "robot")
        text = path.read_text(encoding="utf-8", errors="replace")
    except DocumentError:
        return Declared({}, {})
    arguments: dict[str, str | None] = {}
    for element in root.iter("xacro:arg"):
        if name := element.get("name"):
            arguments.setdefault(name, element.get("default"))
    for name in _USED.findall(_COMMENT.sub("", text)):
        arguments.setdefault(name, None)
    choices: dict[str, list[str]] = {}
    for package, folders, begin, name, end in _BY_ARGUMENT.findall(text):
        try:
            folder = packages.find(package) / folders.strip("/")
        except MissingPartError:
            continue
        found = sorted(folder.glob(f"{begin}*{end}")) if folder.is_dir() else []
        place = -len(Path(end).parts) if end.startswith("/") else -1  # of what the star stands for, from the right
        rest = "" if end.startswith("/") else end
        values = [path.parts[place].removeprefix(begin).removesuffix(rest) for path in found]
        if values:
            choices.setdefault(name, values)
    return Declared(arguments, choices, any(element.tag not in _ASIDE for element in root))
