"""Expanded xacro files, kept in the user's cache: expanding one takes a second, and a task is checked at every edit."""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.base.files import replace_text

from .reading import as_they_were, note, stamps_of

MOST = 64
"""Expansions that are kept; beyond that, those go that were made first."""

_SEARCHED = ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")


def kept(request: Mapping[str, Any]) -> str | None:
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


def keep(request: Mapping[str, Any], text: str, files: list[str]) -> None:
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
