"""`grip convert`: a task in another form."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from grip_bt.base.errors import GripError
from grip_bt.base.files import replace_text

from .streams import put

if TYPE_CHECKING:
    from typing import Any

    from grip_bt.compilers.restructure import Restructured
    from grip_bt.task.catalog import Catalog
    from grip_bt.task.document import Document


def _picture(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.formats import draw

    return str(getattr(draw, f"to_{args.to}")(document.task, catalog, args.view))


def _yaml(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.task import fmt

    return fmt(document.text, document.source)


def _restructured(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.compilers import restructure

    if args.to == "bt":
        form, result = "a behaviour tree", restructure.to_trees(document.task, catalog)
    else:
        form, result = "a state machine", restructure.to_state_machines(document.task, catalog, args.approximate)
    if args.strict:
        result.require_all(form)
    for note in result.notes:
        if not note.by_design:
            print(f"{args.task}: {note}", file=sys.stderr)
    print(f"{args.task}: {_compared(document, result, catalog)}", file=sys.stderr)
    return restructure.to_text(result, form, Path(args.task).name)


def _compared(document: Document, result: Restructured, catalog: Catalog) -> str:
    """Return how the two forms compare, in words."""
    from grip_bt.compilers.restructure import compare

    exact = "" if any(note.approximated for note in result.notes) else "exact by construction, and "
    return f"{exact}{compare(document.task, result, catalog)}"


def _stand_alone(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.formats.standalone import export

    return export(document.task, catalog, None if args.output == "-" else Path(args.output).parent)


def _smach(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.formats.smach_export import export

    return export(document.task, catalog, None if args.output == "-" else Path(args.output).parent)


def _pytrees_xml(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.formats.pytrees_xml import to_xml

    return to_xml(document.task, catalog)


def _btcpp(document: Document, catalog: Catalog, args: argparse.Namespace) -> str:
    from grip_bt.formats.btcpp import to_xml

    return to_xml(document.task, catalog)


Converter = Callable[["Document", "Catalog", argparse.Namespace], str]
# Each form is one entry: what makes its text. What they need is imported when one is asked for.
CONVERTERS: dict[str, Converter] = {
    "svg": _picture,
    "dot": _picture,
    "mermaid": _picture,
    "yaml": _yaml,
    "bt": _restructured,
    "sm": _restructured,
    "pytrees-py": _stand_alone,
    "smach-py": _smach,
    "pytrees-xml": _pytrees_xml,
    "btcpp": _btcpp,
}


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("convert", help="a task as a picture, or in another form")
    parser.add_argument("task", metavar="TASK", help="a task file")
    parser.add_argument(
        "--to",
        required=True,
        choices=sorted(CONVERTERS),
        help="the form; bt and sm: the task itself, made of composites or of state machines;"
        " pytrees-py: a stand-alone Python file; smach-py: Python source of SMACH; pytrees-xml: py_trees' XML;"
        " btcpp: BehaviorTree.CPP 4's XML",
    )
    parser.add_argument(
        "--view", choices=("tree", "flow"), default="tree", help="of a picture: tree (default) or flow chart"
    )
    parser.add_argument(
        "--strict", action="store_true", help="of bt and sm: refuse a task of which a part has no equal in that form"
    )
    parser.add_argument(
        "--approximate",
        action="store_true",
        help="of sm: let reactive composites become machines that aren't quite the same; what differs is shown",
    )
    parser.add_argument("-o", "--output", metavar="OUT", default="-", help="file to write; default: stdout")
    parser.set_defaults(run=run, usage_error=parser.error)


def run(args: argparse.Namespace) -> int:
    """Convert one task."""
    from grip_bt.app.project.catalogue import project_catalog
    from grip_bt.base.yaml.files import read_file
    from grip_bt.task import read_text

    if args.approximate and args.to != "sm":
        args.usage_error("--approximate is for --to sm")
    document = read_text(read_file(args.task), args.task)
    text = CONVERTERS[args.to](document, project_catalog(args.task), args)
    if args.output == "-":
        put(text)
        return 0
    try:
        replace_text(Path(args.output), text)
    except OSError as error:
        raise GripError(f"{args.output}: can't be written: {error.strerror or error}") from error
    return 0
