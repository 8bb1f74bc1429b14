"""`grip convert`: a task in another form."""

from __future__ import annotations

import argparse
import sys
from importlib import import_module
from pathlib import Path

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.project.foreign_code import refuse
from grip_bt.base.files import replace_text
from grip_bt.base.yaml.tree import read_file
from grip_bt.cli.parser import STAND_INS
from grip_bt.cli.terminal import put
from grip_bt.compilers import restructure
from grip_bt.formats.pytrees import import_from_code
from grip_bt.task import dumps, fmt, read_text
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document

FORMATS = {
    "svg": "grip_bt.formats.draw.svg:to_svg",
    "dot": "grip_bt.formats.draw:to_dot",
    "mermaid": "grip_bt.formats.draw:to_mermaid",
    "pytrees-py": "grip_bt.formats.standalone:export",
    "smach-py": "grip_bt.formats.smach_export:export",
    "pytrees-xml": "grip_bt.formats.pytrees:to_xml",
    "btcpp": "grip_bt.formats.btcpp:to_xml",
}
"""Form -> the function that makes its text; loaded when it is asked for, since no other needs it."""
PICTURES, PROGRAMS = ("svg", "dot", "mermaid"), ("pytrees-py", "smach-py")
FORMS = (*FORMATS, "yaml", "bt", "sm")


def converted(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    """Return a task in the form `args.to`."""
    if args.to == "yaml":
        return fmt(document.text, document.source)
    if args.to in ("bt", "sm"):
        return _restructured(document, catalog, args)
    module, _, name = FORMATS[args.to].partition(":")
    more = []
    if args.to in PICTURES:
        more = [args.view]
    elif args.to in PROGRAMS:
        more = [None if args.output == "-" else Path(args.output).parent]
    return str(getattr(import_module(module), name)(document.task, catalog, *more))


def _restructured(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    if args.to == "bt":
        form, result = "a behaviour tree", restructure.to_trees(document.task, catalog)
    else:
        form, result = "a state machine", restructure.to_state_machines(document.task, catalog)
    if args.strict:
        result.require_all(form)
    for note in result.notes:
        if not note.by_design:
            print(f"{args.task}: {note}", file=sys.stderr)
    return restructure.to_text(result, form, Path(args.task).name)


def add_convert(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("task", metavar="TASK", help="a task file")
    form = (
        "the form; bt and sm: the task itself, made of composites or of state machines; pytrees-py: a stand-alone"
        " Python file; smach-py: Python source of SMACH; pytrees-xml: py_trees' XML; btcpp: BehaviorTree.CPP 4's XML"
    )
    add("--to", required=True, choices=sorted(FORMS), help=form)
    add("--view", choices=("tree", "flow"), default="tree", help="of a picture: tree (default) or flow chart")
    add("--strict", action="store_true", help="bt and sm: refuse a task that has no exact equivalent in that form")
    code = "TASK is code that makes a tree of py_trees, as `grip run` takes it: run it to draw the tree"
    add("--execute", action="store_true", help=code)
    add("--stand-ins", action="store_true", help=f"--execute: {STAND_INS}")
    add("-o", "--output", metavar="OUT", default="-", help="file to write; default: stdout")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> None:
    if args.execute:
        refuse([f"--execute: imports and runs {args.task}"])
        task = import_from_code(args.task, Path.cwd(), as_it_is=True, stand_ins=args.stand_ins).task
        document, catalog = read_text(dumps(task), args.task), Catalog.builtin()
    else:
        document, catalog = read_text(read_file(args.task), args.task), project_catalog(args.task)
    text = converted(document, catalog, args)
    if args.output == "-":
        put(text)
    else:
        replace_text(Path(args.output), text)
