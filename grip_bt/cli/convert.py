"""`grip convert`: a task in another form."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from grip_bt.catalog import Catalog
from grip_bt.compilers import draw
from grip_bt.errors import GripError
from grip_bt.graph import fmt, read_text
from grip_bt.graph.document import Document, read_file

from .fmt import replace_text

Converter = Callable[[Document, Catalog, draw.View], str]
# Each form is one entry: what makes its text. Those that run (bt, sm) join here.
CONVERTERS: dict[str, Converter] = {
    "svg": lambda document, catalog, view: draw.to_svg(document.task, catalog, view),
    "dot": lambda document, catalog, view: draw.to_dot(document.task, catalog, view),
    "mermaid": lambda document, catalog, view: draw.to_mermaid(document.task, catalog, view),
    "yaml": lambda document, catalog, view: fmt(document.text, document.source),
}


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("convert", help="a task as a picture, or in another language")
    parser.add_argument("task", metavar="TASK", help="a task file")
    parser.add_argument("--to", required=True, choices=sorted(CONVERTERS), help="the form")
    parser.add_argument(
        "--view", choices=("tree", "flow"), default="tree", help="of a picture: tree (default) or flow chart"
    )
    parser.add_argument("-o", "--output", metavar="OUT", default="-", help="file to write; default: stdout")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Convert one task."""
    from grip_bt.app import project_catalog

    document = read_text(read_file(args.task), args.task)
    text = CONVERTERS[args.to](document, project_catalog(args.task), args.view)
    if args.output == "-":
        sys.stdout.write(text)
        return 0
    try:
        replace_text(Path(args.output), text)
    except OSError as error:
        raise GripError(f"{args.output}: can't be written: {error.strerror or error}") from error
    return 0
