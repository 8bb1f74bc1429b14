"""The example project: where it lies, and a copy of it."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from pathlib import Path

import grip_bt
from grip_bt.base.errors import MissingPartError, NotWritableError
from grip_bt.base.files import copy_folder

_UNWANTED = frozenset({".grip", "__pycache__"})


def examples_folder() -> Path:
    """Return the folder of the example project, writable: the clone's own, or a copy of what is installed."""
    package = Path(grip_bt.__file__).resolve().parent
    own = package.parent / "examples"
    for folder in (own, package / "_examples"):
        if (folder / "grip.yaml").is_file():
            return own if folder == own and os.access(own, os.W_OK) else _copied(folder)
    raise MissingPartError("the example project", "clone the repository, or reinstall the wheel")


def _copied(folder: Path) -> Path:
    """Return a copy in the user's data directory, made once for what is there now: what was changed in it stays."""
    files = [file for file in sorted(folder.rglob("*")) if file.is_file() and _UNWANTED.isdisjoint(file.parts)]
    digest = hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:8]
    base = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "grip"
    copy = base / f"examples-{grip_bt.__version__}-{digest}"
    if copy.is_dir():
        return copy
    try:
        base.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=base) as half:
            copy_folder(folder, Path(half) / "examples", shutil.ignore_patterns(*_UNWANTED))
            (Path(half) / "examples").rename(copy)
    except OSError as error:
        if copy.is_dir():  # another process was quicker
            return copy
        advice = "the example project is copied there; set XDG_DATA_HOME to a folder of yours"
        raise NotWritableError(copy, error, advice) from error
    return copy
