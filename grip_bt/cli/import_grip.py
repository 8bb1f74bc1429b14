"""`grip import --from grip`: tasks and configurations of the first GRIP, into a project folder."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.formats.first_grip import GripImport, import_grip, write_files
from grip_bt.task.document import read_text
from grip_bt.task.validation import validate


def run(args: argparse.Namespace) -> int:
    """Report on what becomes of it, and write the project; 1 when a task has errors that somebody has to mend."""
    if args.execute or args.arguments is not None or args.machine is not None:
        args.usage_error("--execute, --arguments and --machine are for other sources: nothing of the first GRIP is run")
    if not args.path.exists():
        raise GripError(f"{args.path}: there is no such file or folder")
    imported = import_grip(args.path)
    for name, task in imported.tasks.items():
        print(f"task {name}: {len(task.outcomes)} outcomes, {len(task.data)} variables")
    for note in dict.fromkeys(map(str, imported.notes)):
        print(f"  {note}")
    if args.output is None:
        return 0
    return _write(imported, args.output)


def _write(imported: GripImport, folder: Path) -> int:
    texts = dict(imported.texts)
    if "grip.yaml" not in texts and not (folder / "grip.yaml").exists():
        texts["grip.yaml"] = "grip: 1\n"
    try:
        for path in write_files(folder, texts, imported.copies):
            print(f"wrote {path}", file=sys.stderr)
    except FileExistsError as error:
        message = f"{error.args[0]} wasn't made by an import and would be overwritten; move it, or choose another -o"
        raise GripError(message) from None
    except OSError as error:
        raise GripError(f"{folder}: can't be written: {error.strerror or error}") from error
    project, wrong = find_project(folder), 0
    for name in imported.tasks:
        document = read_text(texts[f"tasks/{name}.yaml"], f"tasks/{name}.yaml")
        issues = [
            issue
            for issue in validate(document.task, catalogue_of(project), document).issues
            if issue.severity == "error"
        ]
        for issue in issues:
            print(f"  to do    tasks/{name}.yaml: {issue.path}: {issue.message}")
        wrong += bool(issues)
    return int(wrong > 0)
