"""`grip import`: tasks from elsewhere. Each source is a package of `formats` with a function `read`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import Project, find_project
from grip_bt.app.project.foreign_code import refuse
from grip_bt.base.errors import GripError, listing
from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.cli.parser import STAND_INS, add_no_code
from grip_bt.cli.terminal import Bar, put, tell
from grip_bt.formats.imported import Imported, Request, generated_by, write_generated
from grip_bt.nodes.tree_code import is_tree_code
from grip_bt.task import Task, dumps
from grip_bt.task.document import read
from grip_bt.task.validation import validate

_PACKAGES = {"btcpp": "btcpp", "grip": "first_grip", "pytrees": "pytrees", "smach": "smach"}
_OPTIONS = {
    "btcpp": ("machine", "more"),
    "grip": (),
    "pytrees": ("execute", "stand_ins"),
    "smach": ("machine", "execute", "arguments", "success"),
}
"""Source -> its package in `formats`, and the options that aren't for every source."""
_ONE, _PROJECT = ("btcpp", "pytrees"), ("grip",)
"""Sources that give one task, which goes to stdout without `-o`; and those whose `-o` is the folder of a project."""


def add_import(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    path = (
        "smach: a Python file, or a folder of them; pytrees: an XML file, or with --execute module:function,"
        " file.py:function or file.py, a program; btcpp: an XML file of version 4, several, or a folder; grip: a task"
        " or configuration of the first GRIP (.yaml), or a folder"
    )
    add("path", type=Path, metavar="PATH", help=path)
    add("more", type=Path, nargs="*", metavar="MORE", help="btcpp: further files of the same project")
    sources, name = sorted(_PACKAGES), lambda word: word.replace("py_trees", "pytrees")
    add("--from", dest="source", required=True, type=name, choices=sources, help="format of the source")
    out = (
        "a .yaml file for one task, a folder for several, of grip a project folder; without it, smach and grip write"
        " nothing, and the others write to stdout"
    )
    add("-o", "--output", type=Path, metavar="OUT", help=out)
    add("--machine", metavar="NAME", help="only this one of several machines or trees")
    code = "also run the code, in a process of its own, to see what it builds: only for code that you trust"
    add("--execute", action="store_true", help=code)
    add("--stand-ins", action="store_true", help=f"pytrees: {STAND_INS}")
    given = "--execute of smach, YAML or JSON: parameter -> value, or class or function -> parameter -> value"
    add("--arguments", type=Path, metavar="FILE", help=given)
    outcome = "smach: an outcome that means success, whatever it is called"
    add("--success", action="append", metavar="OUTCOME", help=outcome)
    add("--report", action="store_true", help="print the report only; write nothing")
    add("--json", action="store_true", help="print the report as one JSON object; tasks go to -o alone")
    add_no_code(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Import, report and write; 1 when something wasn't imported, or a task that was written has errors."""
    _check_options(args)
    around = find_project(args.path)
    project = _project_at(_folder(args.output)) if args.output is not None else around
    with Bar("files") as bar:
        imported = import_module(f"grip_bt.formats.{_PACKAGES[args.source]}").read(
            Request(
                args.path,
                lambda: catalogue_of(project),
                _nodes(project),
                bound=around.folder if (around.folder / "grip.yaml").is_file() else None,
                select=args.machine or "",
                execute=args.execute,
                stand_ins=args.stand_ins,
                arguments=_arguments(args.arguments),
                success=tuple(args.success or ()),
                progress=bar,
                more=tuple(args.more),
            )
        )
    if args.json:
        tell(True, imported.as_dict())
    elif args.report or args.output is not None or args.source not in _ONE:
        put(imported.text())
    else:
        sys.stderr.write(imported.text())
        put(_task_text(imported.task, args))
    errors = False if args.report or args.output is None else _write(imported, args)
    return int(imported.failed or errors)


def _check_options(args: argparse.Namespace) -> None:
    for option in ("machine", "execute", "stand_ins", "arguments", "success", "more"):
        if getattr(args, option) and option not in _OPTIONS[args.source]:
            what = f"--{option.replace('_', '-')} isn't" if option != "more" else "several paths aren't"
            args.usage_error(f"{what} for --from {args.source}")
    if args.arguments is not None and not args.execute:
        args.usage_error("--arguments are for --execute")
    if args.execute and args.source == "pytrees" and not is_tree_code(str(args.path)):
        args.usage_error("--execute is for module:function, or a Python file; an XML file is only read")
    if args.execute:
        refuse([f"--execute: imports and runs {args.path}"])


def _arguments(path: Path | None) -> Mapping[str, Mapping[str, Any]]:
    if path is None:
        return {}
    given = to_data(parse(read_file(path), str(path)))
    if not isinstance(given, dict):
        raise GripError(
            f"{path}: write parameter -> value, or class or function -> parameter -> value: `Meet: {{times: 3}}`"
        )
    for_all = {name: value for name, value in given.items() if not isinstance(value, dict)}
    return {"": for_all, **{name: each for name, each in given.items() if isinstance(each, dict)}}


def _folder(output: Path) -> Path:
    return output.parent if output.suffix in (".yaml", ".yml") else output


def _project_at(folder: Path) -> Project:
    """Return the project that a folder belongs to, or the folder itself, which may not be there yet."""
    found = find_project(folder)
    return found if (found.folder / "grip.yaml").is_file() else replace(found, folder=folder.resolve())


def _nodes(project: Project) -> Path:
    return project.folder / (project.file.nodes or "nodes")


def _task_text(task: Task, args: argparse.Namespace) -> str:
    return f"# {generated_by(args.source)} from {args.path.name}.\n{dumps(task)}"


def _write(imported: Imported, args: argparse.Namespace) -> bool:
    output = args.output
    folder, files = _folder(output), dict(imported.files)
    one, whole = folder != output, args.source in _PROJECT
    if one and (whole or len(imported.tasks) != 1):
        names = listing(imported.tasks)
        raise GripError(f"{output} holds one task (available: {names}); choose one with --machine, or give a folder")
    if whole and "grip.yaml" not in files and not (folder / "grip.yaml").exists():
        files["grip.yaml"] = "grip: 1\n"
    project = _project_at(folder)
    home, nodes = (folder, folder / "nodes") if whole else (project.folder, _nodes(project))
    where = folder / "tasks" if whole else folder
    tasks = {output if one else where / f"{name}.yaml": task for name, task in imported.tasks.items()}
    texts = {path: _task_text(task, args) for path, task in tasks.items()}
    for name, text in files.items():
        texts[nodes / name.removeprefix("nodes/") if name.startswith("nodes/") else home / name] = text
    copies = {home / name: path for name, path in imported.copies.items()}
    for path in write_generated(texts, args.source, copies):
        print(f"wrote {path}", file=sys.stderr)
    catalog, wrong = catalogue_of(find_project(folder)), False
    for path in tasks:
        document = read(path)
        errors = validate(document.task, catalog, document).errors
        for issue in errors:
            print(f"  to do: {issue}", file=sys.stderr if args.json else sys.stdout)
        wrong |= bool(errors)
    return wrong
