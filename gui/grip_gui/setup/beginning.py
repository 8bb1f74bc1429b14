"""How a project begins, or is completed: with a robot, or as the example; and where on this machine things lie.

`python -m grip_gui.setup.beginning` does the work in a process of its own: planning is of the extra `motion`.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

from grip_bt.app.project.examples import examples_folder
from grip_bt.app.project.folder import FILE_NAME, make_project
from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.commanders.description.packages import MANIFEST, ROBOTS
from grip_gui.processes import answer_question
from grip_gui.setup.robot_facts import data_in
from grip_gui.setup.settings_store import set_value
from grip_gui.wire import setup as wire

_SHOWN = ".urdf .xacro .srdf .xml .py .yaml .launch .srv .action .scene .obj .stl .ply .dae".split()
_OF_ROBOT = ("robot", "arms", "hands")


def robots() -> dict[str, str]:
    """Return the ready-made robots with the sentence that begins each one's file."""
    return {name: file.read_text("utf-8").partition("\n")[0].lstrip("# ") for name, file in sorted(ROBOTS.items())}


def pairs() -> dict[str, dict[str, Any]]:
    """Return what each ready-made arm with a hand says of itself: `arm`, `hand`, `mount`, and more."""
    return {name: said for name, file in sorted(ROBOTS.items()) if "arm" in (said := data_in(file) or {})}


def browse(at: str, folder: Path) -> wire.FolderView:
    """Return what lies in a folder of this machine, `folder` where none is given: names, never what is in a file."""
    here = Path(at) if at else folder
    if "\0" in at or not here.is_absolute() or not here.is_dir():
        raise DocumentError("this folder isn't there", at)
    try:
        inside = sorted((p for p in here.iterdir() if p.name[0] != "."), key=lambda p: p.name.lower())
    except OSError as error:
        raise DocumentError(f"this folder can't be read: {error.strerror}", at) from error
    entries = {each.name: _kind_of(each) for each in inside if each.is_dir()}
    entries |= {each.name: "file" for each in inside if each.suffix in _SHOWN and each.is_file()}
    above = "" if here.parent == here else str(here.parent)
    return wire.FolderView(at=str(here), above=above, kind=_kind_of(here), entries=entries)


def _kind_of(folder: Path) -> wire.EntryKind:
    if (folder / ".setup_assistant").is_file() or any(folder.glob("config/*.srdf*")):
        return "moveit"
    return "package" if (folder / MANIFEST).is_file() else "folder"


def examples() -> dict[str, str]:
    """Return the tasks of the example project with what each says of itself."""
    files = sorted((examples_folder() / "tasks").glob("*.yaml"))
    return {file.stem: said.get("doc", "") for file in files if "root" in (said := data_in(file) or {})}


def check_request(request: wire.BeginRequest, folder: Path) -> None:
    """Refuse what names no robot, and an example in a project that has begun."""
    source = request.robot
    if request.example:
        if (folder / FILE_NAME).exists():
            raise GripError("this project has begun already; open an example in a folder of its own")
    elif not source and not (data_in(folder / FILE_NAME) or {}).get("robot"):
        raise GripError("grip.yaml names no robot yet: choose one")
    if source and source not in ROBOTS and ("\0" in source or not Path(source).is_absolute()):
        raise GripError(f"{source!r} is neither a ready-made robot nor a path on this machine")


def begin(folder: str, robot: str, example: str, chosen: Sequence[str]) -> Mapping[str, Any]:
    """Copy the example project, or write what a project for a robot lacks: parts, a camera, a world, first tasks.

    What is there stays, but that another robot than before brings its arms and hands. `choices` in the answer have to
    be chosen among first.
    """
    from grip_bt.app.project.new_robot import new_robot

    undecided: dict[str, Any] = {}

    def choose(question: str, names: Sequence[str]) -> str:
        if not any(name in names for name in chosen):
            undecided.update(question=question, choices=list(names))
        return next((name for name in chosen if name in names), names[0])

    home = Path(folder)
    if example:
        unwanted = shutil.ignore_patterns(".grip", "__pycache__")
        shutil.copytree(examples_folder(), home, ignore=unwanted, dirs_exist_ok=True)
        return {"files": [f"tasks/{example}.yaml"]}
    made = new_robot(robot or folder, home, choose)
    if undecided:
        return undecided
    file, fresh = home / FILE_NAME, to_data(parse(made.files[FILE_NAME]))
    before = file.read_text("utf-8") if file.exists() else ""
    now = to_data(parse(before)) if before else {}
    lacking: dict[tuple[str, ...], Any] = {
        (k,): v for k, v in fresh.items() if not now.get(k) or robot and k in _OF_ROBOT
    }
    keeps = before and not lacking.keys() & {("arms",), ("hands",)}  # tasks would speak of arms by other names
    said, found = (r.get("states") if isinstance(r, dict) else None for r in (now.get("robot"), fresh["robot"]))
    if not keeps and found != said:  # where arms rest and nothing touches: the tasks that are written begin there
        described = isinstance(now.get("robot"), dict)
        lacking |= {("robot", "states"): found} if described else {("robot",): fresh["robot"]}
    given = {path: text for path, text in made.files.items() if not (keeps and path.startswith("tasks/"))}
    written = [str(path) for path in make_project(home, given, beside=True) if given.get(str(path))]
    if before and lacking:
        file.write_text(reduce(lambda text, key: set_value(text, key, lacking[key]), lacking, before), "utf-8")
        written.append(FILE_NAME)
    return {"files": written, "findings": list(dict.fromkeys(map(str, made.findings)))}


if __name__ == "__main__":
    sys.exit(answer_question(begin))
