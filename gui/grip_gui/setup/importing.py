"""Tasks from elsewhere: a file that the page sends is kept in the project and read, never executed."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from grip_bt.base.errors import GripError
from grip_gui.editing.files import TextFile
from grip_gui.processes import Prober
from grip_gui.project import ProjectFolder
from grip_gui.wire.setup import ImportView, ImportWish

FOLDER = "legacy"
"""Where the file itself is kept, so that an import can be done again."""
SUFFIXES = {"smach": ".py", "btcpp": ".xml", "pytrees": ".xml"}


async def import_file(folder: ProjectFolder, prober: Prober, wish: ImportWish) -> ImportView:
    """Keep a file and make tasks of what it holds.

    Args:
        folder: the project.
        prober: runs `grip import`.
        wish: the file's name and text, and what it is.

    Returns:
        what the import said, and the task files that are new or changed.

    Raises:
        GripError: the name is none of such a file, or another file of this name is kept already.
        DocumentError: it can't be written.
    """
    suffix = SUFFIXES[wish.source]
    stem = PurePosixPath(wish.name).stem
    if PurePosixPath(wish.name).suffix != suffix or PurePosixPath(wish.name).name != wish.name:
        raise GripError(f"{wish.name!r}: a file of {wish.source} ends with {suffix} and has no folder in its name")
    kept = TextFile(folder.folder / FOLDER / wish.name, f"{FOLDER}/{wish.name}")
    if not kept.path.resolve().is_relative_to(folder.folder):
        raise GripError(f"{kept.name}: leads out of the project folder")
    if kept.path.exists() and kept.read() != wish.text:
        raise GripError(f"{kept.name} is there with another text; give the file another name")
    kept.write(wish.text)
    before = _stamps(folder)
    out = "tasks" if wish.source == "smach" else f"tasks/{stem}.yaml"
    view = await prober.run(("import", kept.name, "--from", wish.source, "-o", out))
    after = _stamps(folder)
    return ImportView(probe=view, tasks=sorted(path for path in after if after[path] != before.get(path)))


def _stamps(folder: ProjectFolder) -> dict[str, int]:
    return {entry.path: Path(folder.folder / entry.path).stat().st_mtime_ns for entry in folder.tasks()}
