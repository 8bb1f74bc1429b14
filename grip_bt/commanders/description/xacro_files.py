"""xacro files, expanded by the `xacro` package in a process with limits.

Expanded ones are kept in the user's cache: expanding one takes up to a second, and a task is checked at every edit.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError
from grip_bt.base.files import replace_text
from grip_bt.base.interpreter import python_command

from .files import as_they_were, note, stamps_of
from .packages import Packages
from .xml import Element, parse_xml, read_xml

MOST = 64
"""Expansions that are kept; beyond that, those go that were made first."""

_SEARCHED = ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")


def kept_expansion(request: Mapping[str, Any]) -> str | None:
    """Return the text that a request gave, where no file that it read has changed since."""
    try:
        entry = json.loads(_place(request).read_text(encoding="utf-8"))
        text, stamps = str(entry["text"]), [tuple(stamp) for stamp in entry["stamps"]]
        if not as_they_were(stamps):
            return None
    except (OSError, ValueError, KeyError, TypeError):
        return None
    note(*(Path(stamp[0]) for stamp in stamps))
    return text


def keep_expansion(request: Mapping[str, Any], text: str, files: list[str]) -> None:
    """Keep what a request gave, with the files that it read; where nothing can be written, nothing is kept."""
    note(*map(Path, files))
    place = _place(request)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        replace_text(place, json.dumps({"text": text, "stamps": stamps_of(files)}))
        for old in sorted(place.parent.glob("*.json"), key=lambda p: p.stat().st_mtime_ns)[:-MOST]:
            old.unlink(missing_ok=True)
    except OSError:
        return


def _place(request: Mapping[str, Any]) -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    searched = [request, sys.prefix, *(os.environ.get(name, "") for name in _SEARCHED)]
    name = hashlib.sha256(json.dumps(searched, sort_keys=True).encode()).hexdigest()[:32]
    return base / "grip" / "xacro" / f"{name}.json"


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
    if (text := kept_expansion(request)) is not None:
        return text
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
    keep_expansion(request, str(reply["text"]), reply["files"])
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
