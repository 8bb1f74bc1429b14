"""Tasks from elsewhere: a file that the page sends is kept in the project and read, never executed."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from grip_bt.base.errors import GripError
from grip_gui.editing.files import TextFile
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.wire.setup import ImportRequest, ImportView

FOLDER = "legacy"
"""Where the file itself is kept, so that an import can be done again."""
SUFFIXES = {"smach": ".py", "btcpp": ".xml", "pytrees": ".xml"}


async def import_file(folder: ProjectFolder, runner: CommandRunner, request: ImportRequest) -> ImportView:
    """Keep a file and make tasks of what it holds.

    Args:
        folder: the project.
        runner: runs `grip import`.
        request: the file's name and text, and what it is.

    Returns:
        what the import said, and the task files that are new or changed.

    Raises:
        GripError: the name is none of such a file, or another file of this name is kept already.
        DocumentError: it can't be written.
    """
    suffix = SUFFIXES[request.source]
    stem = PurePosixPath(request.name).stem
    if PurePosixPath(request.name).suffix != suffix or PurePosixPath(request.name).name != request.name:
        raise GripError(
            f"{request.name!r}: a file of {request.source} ends with {suffix} and has no folder in its name"
        )
    kept = TextFile(folder.folder / FOLDER / request.name, f"{FOLDER}/{request.name}")
    if not kept.path.resolve().is_relative_to(folder.folder):
        raise GripError(f"{kept.name}: leads out of the project folder")
    if kept.path.exists() and kept.read() != request.text:
        raise GripError(f"{kept.name} is there with another text; give the file another name")
    kept.write(request.text)
    before = _stamps(folder)
    out = "tasks" if request.source == "smach" else f"tasks/{stem}.yaml"
    view = await runner.run(("import", kept.name, "--from", request.source, "-o", out))
    after = _stamps(folder)
    return ImportView(probe=view, tasks=sorted(path for path in after if after[path] != before.get(path)))


def _stamps(folder: ProjectFolder) -> dict[str, int]:
    return {entry.path: Path(folder.folder / entry.path).stat().st_mtime_ns for entry in folder.tasks()}
