"""xacro files, expanded by the `xacro` package in a process with limits."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.base.interpreter import python_command

from .files import note
from .packages import Packages
from .xml import Element, parse_xml, read_xml

TIME = 30.0
"""After so long a file won't end any more [s]; large robots take one or two."""
MODULE = "grip_bt.commanders.description.xacro_process"


def expand(path: Path, arguments: Mapping[str, object], packages: Packages) -> str:
    """Return a xacro file's XML.

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
        "arguments": {name: _word(value) for name, value in arguments.items()},
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
    return str(reply["text"])


def expanded(path: Path, arguments: Mapping[str, object], packages: Packages, root: str = "robot") -> Element:
    """Return a xacro file as its tree; lines are those of the expanded text.

    Raises:
        DocumentError: it can't be expanded, or gives something else.
    """
    return parse_xml(expand(path, arguments, packages), root, str(path))


def declared_arguments(path: Path) -> tuple[str, ...]:
    """Return the names of the arguments that a xacro file declares itself, in order."""
    names = (e.get("name", "") for e in read_xml(path, "robot").iter("xacro:arg"))
    return tuple(dict.fromkeys(filter(None, names)))


def _word(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
