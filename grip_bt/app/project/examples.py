"""The packaged demonstrations: which task, and which of its nodes the summary speaks of."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

import grip_bt
from grip_bt.base.errors import MissingPartError, NotWritableError, UnknownNameError


@dataclass(frozen=True)
class Demo:
    """One demonstration.

    Attributes:
        name: as on the command line.
        doc: what is to be seen, in a line.
        task: the task file.
        attempt: path of the node that is one attempt.
        check: path of the leaf that checks whether something is held.
    """

    name: str
    doc: str
    task: Path
    attempt: str
    check: str


DEMOS = ("reactive",)


def find_demo(name: str) -> Demo:
    """Return a demonstration.

    Raises:
        UnknownNameError: there is none of that name.
    """
    if name not in DEMOS:
        raise UnknownNameError("demonstration", name, DEMOS)
    return Demo(
        name,
        "A Panda arm with an Allegro hand clears a table: look, choose a grasp, take, check by images, place.",
        examples_folder() / "tasks" / "reactive_pick.yaml",
        "next_object/attempt",
        "next_object/attempt/check/held",
    )


def examples_folder() -> Path:
    """Return the folder of the example project, writable: the clone's own, or a copy of the installed one.

    Raises:
        MissingPartError: this installation has no examples.
    """
    package = Path(grip_bt.__file__).resolve().parent
    for folder in (package.parent / "examples", package / "_examples"):
        if (folder / "grip.yaml").is_file():
            return folder if os.access(folder, os.W_OK) else _copy(folder)
    raise MissingPartError("the example project", "clone the repository, or install the wheel anew")


def _copy(folder: Path) -> Path:
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    copy = base / "grip" / f"examples-{grip_bt.__version__}"
    try:
        shutil.copytree(folder, copy, dirs_exist_ok=True)
    except OSError as error:
        advice = "the example project is copied there; set XDG_CACHE_HOME to a folder of yours"
        raise NotWritableError(copy, error, advice) from error
    return copy
