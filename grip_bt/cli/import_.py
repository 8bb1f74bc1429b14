"""`grip import`: tasks from elsewhere; this file is the verb and SMACH, each other source has one of its own."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from grip_bt.app.project.folder import find_project
from grip_bt.app.project.foreign_code import refuse
from grip_bt.base.errors import GripError
from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.formats.smach import ImportedFile, advice, import_file, import_with_execution, write_import

from . import import_btcpp, import_grip, import_pytrees
from .parser import add_no_code


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument(
        "path",
        type=Path,
        metavar="PATH",
        help="smach: a Python file, or a folder of them; pytrees: an XML file, or module:factory with --execute;"
        " btcpp: an XML file of version 4; grip: a task or configuration of the first GRIP (.ini, .yaml), or a folder",
    )
    parser.add_argument("--from", dest="source", required=True, choices=sorted(IMPORTERS), help="what it is")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUT",
        help="a .yaml file for one task, a folder for several, of grip a project folder; without it smach and grip"
        " write nothing, the others stdout",
    )
    parser.add_argument("--machine", metavar="NAME", help="only this one of several machines, or trees")
    parser.add_argument(
        "--execute",
        action="store_true",
        help="also run the code, in a process of its own, to see what it builds: only for code that you trust",
    )
    parser.add_argument(
        "--arguments",
        type=Path,
        metavar="FILE",
        help="for --execute of smach, YAML or JSON: class or function -> parameter -> value",
    )
    parser.add_argument(
        "--report", action="store_true", help="of btcpp: say what becomes of the file, and write nothing"
    )
    add_no_code(parser)
    parser.set_defaults(run=run, usage_error=parser.error)


def run(args: argparse.Namespace) -> int:
    """Import from one source."""
    if args.execute:
        refuse([f"--execute: imports and runs {args.path}"])
    return IMPORTERS[args.source](args)


def import_smach(args: argparse.Namespace) -> int:
    """Report on every container; 1 when one of them wasn't imported."""
    if args.arguments is not None and not args.execute:
        args.usage_error("--arguments are for --execute")
    files = _files(args.path)
    root = args.path if args.path.is_dir() else None
    given = _arguments(args.arguments)
    if args.execute:
        imports = [import_with_execution(file, root, given) for file in files]
    else:
        imports = [import_file(file, root) for file in files]
    if len(imports) == 1 and imports[0].error:
        raise GripError(imports[0].error)
    for imported in imports:
        _report(imported)
        for line in advice(imported, args.execute, given) if imported.containers else ():
            print(f"  to do: {line}")
    if not any(imported.containers or imported.error for imported in imports):
        raise GripError(f"{args.path}: no SMACH machine was found")
    if args.output is not None:
        _write([i for i in imports if i.tasks], args)
    return int(any(i.error or i.verdicts()["failed"] for i in imports))


def _files(path: Path) -> list[Path]:
    if path.is_dir():
        return sorted(p for p in path.rglob("*.py") if not any(part.startswith(".") for part in p.parts))
    if not path.is_file():
        raise GripError(f"{path}: there is no such file or folder")
    return [path]


def _arguments(path: Path | None) -> dict[str, dict[str, Any]]:
    if path is None:
        return {}

    given = to_data(parse(read_file(path), str(path)))
    if not isinstance(given, dict) or not all(isinstance(each, dict) for each in given.values()):
        raise GripError(f"{path}: write class or function -> parameter -> value, such as `Meet: {{times: 3}}`")
    return given


def _report(imported: ImportedFile) -> None:
    if imported.error:
        print(f"{imported.error}")
    if not imported.containers:
        return
    counts = ", ".join(f"{n} {verdict}" for verdict, n in imported.verdicts().items() if n)
    old = " (Python 2)" if imported.converted else ""
    print(f"{imported.file.name}{old}: {counts}")
    for found in imported.containers:
        name = found.kind if found.cls == found.kind else f"{found.cls} ({found.kind})"
        print(f"  {found.verdict:<8}{found.span.line:>5}  {name}")
        for problem in found.problems:
            print(f"{'':>17}{problem}")


def _write(imports: list[ImportedFile], args: argparse.Namespace) -> None:
    every = [(imported, name) for imported in imports for name in imported.tasks]
    chosen = [(i, name) for i, name in every if args.machine in (None, name)]
    names = ", ".join(name for _, name in every) or "none"
    if not chosen:
        raise GripError(f"nothing to write: no such machine was imported (there are: {names})")
    one = args.output.suffix in (".yaml", ".yml")
    if one and len(chosen) > 1:
        raise GripError(f"{args.output} holds one machine; choose one of {names} by --machine, or give a folder")
    folder = args.output.parent if one else args.output
    folder.mkdir(parents=True, exist_ok=True)
    project = find_project(folder)
    nodes = project.folder / (project.file.nodes or "nodes")
    for imported in imports:
        mine = [name for i, name in chosen if i is imported]
        if mine:
            paths = {name: args.output if one else folder / f"{_stem(imported, name)}.yaml" for name in mine}
            for path in write_import(imported, paths, nodes):
                print(f"wrote {path}", file=sys.stderr)


def _stem(imported: ImportedFile, name: str) -> str:
    return name if name == imported.file.stem else f"{imported.file.stem}_{name}"


# Each source is one entry; what it needs is imported when it is asked for.
IMPORTERS: dict[str, Callable[[argparse.Namespace], int]] = {
    "btcpp": import_btcpp.run,
    "grip": import_grip.run,
    "smach": import_smach,
    "pytrees": import_pytrees.run,
}
