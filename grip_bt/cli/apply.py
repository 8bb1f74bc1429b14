"""`grip apply`: edit commands on a task file, as the editor and Python give them; only their own lines change."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError, EditError
from grip_bt.base.files import replace_text
from grip_bt.compilers.restructure import expanded, extracted
from grip_bt.task import read
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document
from grip_bt.task.edit import Edited, Extract, apply_to_document, command_of

from .terminal import put


def add_apply(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("task", metavar="TASK", help="a task file; it is changed")
    parser.add_argument(
        "command",
        help='a command, or a list, in JSON, such as \'{"do": "rename", "path": "a", "name": "b"}\'; - reads stdin',
    )
    parser.add_argument("--inverse", metavar="FILE", help="write the command that undoes everything")
    parser.add_argument("--dry-run", action="store_true", help="print the resulting text; change no file")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Apply the commands in their order, all or none."""
    words = sys.stdin.read() if args.command == "-" else args.command
    document, catalog = read(args.task), project_catalog(args.task)
    files: dict[str, str] = {}
    inverses: list[Any] = []
    for data in _listed(words):
        edited = _applied(data, document, catalog, files)
        document = edited.document
        inverses.insert(0, edited.inverse.model_dump(mode="json"))
    if args.dry_run:
        put(document.text)
        return 0
    if args.inverse:  # first: where it can't be written, the task stays as it is
        replace_text(Path(args.inverse), json.dumps(inverses, indent=1) + "\n")
    for name, text in files.items():
        file = find_project(Path(args.task).resolve()).folder / name
        if file.exists():
            raise EditError("", f"{file} already exists; choose another file for the part")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    replace_text(Path(args.task), document.text)
    print(f"{args.task}: {len(inverses)} command{'s' * (len(inverses) != 1)} applied")
    return 0


def _listed(words: str) -> list[Any]:
    try:
        data = json.loads(words)
    except json.JSONDecodeError as error:
        raise DocumentError(f"no JSON: {error.msg}", "<command>", error.lineno, error.colno) from None
    return data if isinstance(data, list) else [data]


def _applied(data: object, document: Document, catalog: Catalog, files: dict[str, str]) -> Edited:
    try:
        command = command_of(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise DocumentError(f"no command: {place}: {first['msg']}; docs/editing.md lists them", "<command>") from None
    if isinstance(command, Extract):
        part = extracted(command, document, catalog)
        files[part.file] = part.text
        return apply_to_document(document, part.edit)
    return apply_to_document(document, expanded(command, document.task, catalog))
