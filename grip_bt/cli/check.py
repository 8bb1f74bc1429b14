"""`grip check`: all issues of tasks at once."""

from __future__ import annotations

import argparse
import json

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.issue import Issue
from grip_bt.base.yaml.tree import read_file
from grip_bt.task import read_text, schema
from grip_bt.task.validation import validate

from .terminal import counted


def add_check(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="a task file")
    parser.add_argument("--strict", action="store_true", help="1 also where there are only warnings, for CI")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of task files")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the issues of all tasks; 1 when one of them has an error, or a warning where that is asked for."""
    if args.schema:
        print(json.dumps(schema(), indent=2))
        return 0
    if not args.tasks:
        args.usage_error("name at least one TASK, or ask for the --schema")
    found = {path: _issues(path) for path in args.tasks}
    wrong = any(args.strict or issue.severity == "error" for issues in found.values() for issue in issues)
    if args.json:
        print(json.dumps([{"task": path, "issues": [i.as_dict() for i in found[path]]} for path in found], indent=2))
        return int(wrong)
    for path, issues in found.items():
        for issue in issues:
            print(issue)
        errors = sum(issue.severity == "error" for issue in issues)
        print(f"{path}: {counted(errors, len(issues) - errors)}")
    return int(wrong)


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
