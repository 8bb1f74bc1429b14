"""A new project folder: the files of `template/`, and a folder for each kind of thing that a project holds."""

from __future__ import annotations

import shutil
from pathlib import Path

from grip_bt.base.errors import ProjectExistsError

TEMPLATE = Path(__file__).with_name("template")
FOLDERS = ("tasks", "components", "nodes", "messages")


def make_project(folder: str | Path) -> list[Path]:
    """Make a project in a folder that isn't there yet or is empty (a `.git` in it is no harm).

    Returns:
        The files written, relative to the folder.

    Raises:
        ProjectExistsError: The folder holds something, or is a file; nothing was written.
    """
    folder = Path(folder)
    if folder.exists() and (not folder.is_dir() or any(entry.name != ".git" for entry in folder.iterdir())):
        raise ProjectExistsError(folder)
    written = []
    for source in sorted(file for file in TEMPLATE.rglob("*") if file.is_file()):
        relative = source.relative_to(TEMPLATE)
        # A file of this name in the package's own folder would hide files from git and from the package's build.
        relative = relative.with_name(".gitignore") if relative.name == "gitignore" else relative
        (folder / relative).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, folder / relative)
        written.append(relative)
    for name in FOLDERS:
        (folder / name).mkdir(exist_ok=True)
    return written
