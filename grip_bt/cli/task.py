"""`grip check`, `grip fmt`, `grip apply`: the issues of task files, their canonical form, commands that edit them."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError, EditError, GripError, plural
from grip_bt.base.files import replace_text
from grip_bt.base.issue import Issue
from grip_bt.base.yaml.tree import read_file
from grip_bt.cli.terminal import counted, put, tell
from grip_bt.task import fmt, read, read_text, schema
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document
from grip_bt.task.validation import validate


def add_check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="a task file, or a project's folder for all its tasks")
    parser.add_argument("--strict", action="store_true", help="1 also where there are only warnings, for CI")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of task files")


def run_check(args: argparse.Namespace) -> int:
    if args.schema:
        print(json.dumps(schema(), indent=2))
        return 0
    if not args.tasks:
        args.usage_error("name at least one TASK, or ask for the --schema")
    found = {path: _issues(path) for named in args.tasks for path in _task_files(named)}
    wrong = any(args.strict or issue.severity == "error" for issues in found.values() for issue in issues)
    lines = []
    for path, issues in found.items():
        errors = sum(issue.severity == "error" for issue in issues)
        lines += [*map(str, issues), f"{path}: {counted(errors, len(issues) - errors)}"]
    tell(args.json, [{"task": path, "issues": [i.as_dict() for i in found[path]]} for path in found], lines)
    return int(wrong)


def _task_files(path: str) -> list[str]:
    """Return a file itself, and the task files of a project's folder."""
    tasks = Path(path) / "tasks"
    if not tasks.is_dir():
        return [path]
    return [str(file) for file in sorted(tasks.rglob("*.yaml")) if not file.name.endswith(".layout.yaml")]


def _issues(path: str) -> tuple[Issue, ...]:
    """Return the issues of a file; what keeps it from being read is one too."""
    try:
        document = read_text(read_file(path), path)
    except DocumentError as error:
        message = error.message.rstrip(".")
        return (Issue("", "bad-document", "error", message, "", error.line or 1, error.column or 1, error.source),)
    try:
        catalog = project_catalog(path)
    except GripError as error:
        return (Issue("", "bad-project", "error", str(error), source=path, line=1, column=1),)
    return validate(document.task, catalog, document).issues


def add_fmt(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("tasks", nargs="+", metavar="TASK", help="a task file; - reads stdin and writes stdout")
    parser.add_argument("--check", action="store_true", help="change nothing; 1 when a file isn't canonical")
    parser.add_argument("--json", action="store_true", help="print one JSON list")


def run_fmt(args: argparse.Namespace) -> int:
    texts = {path: sys.stdin.read() if path == "-" else read_file(path) for path in args.tasks}
    # a file that can't be read stops all before any is written
    formatted = {path: fmt(text, "<stdin>" if path == "-" else path) for path, text in texts.items()}
    changed = [path for path, text in texts.items() if text != formatted[path]]
    advice = "not formatted; run `grip fmt {}`" if args.check else "formatted"
    for path, text in () if args.check else formatted.items():
        if path == "-":
            put(text)
        elif path in changed:
            replace_text(Path(path), text)
    if args.check or "-" not in args.tasks:
        rows = [{"task": path, "changed": path in changed} for path in texts]
        tell(args.json, rows, (f"{path}: {advice.format(path)}" for path in changed))
    return int(args.check and bool(changed))


def add_apply(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("task", metavar="TASK", help="a task file; it is changed")
    form = 'a command, or a list, in JSON, such as \'{"do": "rename", "path": "a", "name": "b"}\'; - reads stdin'
    parser.add_argument("command", help=form)
    parser.add_argument("--dry-run", action="store_true", help="print the resulting text; change no file")


def run_apply(args: argparse.Namespace) -> None:
    words = sys.stdin.read() if args.command == "-" else args.command
    document, catalog = read(args.task), project_catalog(args.task)
    files: dict[str, str] = {}
    commands = _listed(words)
    for data in commands:
        document = _applied(data, document, catalog, files)
    if args.dry_run:
        put(document.text)
        return
    for name, text in files.items():
        file = find_project(Path(args.task).resolve()).folder / name
        if file.exists():
            raise EditError("", f"{file} already exists; choose another file for the part")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    replace_text(Path(args.task), document.text)
    print(f"{args.task}: {plural(len(commands), 'command')} applied")


def _listed(words: str) -> list[Any]:
    try:
        data = json.loads(words)
    except json.JSONDecodeError as error:
        raise DocumentError(f"no JSON: {error.msg}", "<command>", error.lineno, error.colno) from None
    return data if isinstance(data, list) else [data]


def _applied(data: object, document: Document, catalog: Catalog, files: dict[str, str]) -> Document:
    from grip_bt.compilers.restructure import expanded, extracted  # for this verb alone: `check` is to answer at once
    from grip_bt.task.edit import Extract, apply_to_document, command_of

    command = command_of(data)
    if isinstance(command, Extract):
        part = extracted(command, document, catalog)
        files[part.file] = part.text
        return apply_to_document(document, part.edit).document
    return apply_to_document(document, expanded(command, document.task, catalog)).document
