"""`grip interfaces build`: build ROS interface packages with no ROS installation."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from grip_bt.ros.interfaces import build_interfaces


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    build = actions.add_parser("build", help="build the .msg, .srv and .action packages in a folder, once per content")
    build.add_argument("folder", type=Path, help="an interface package, or a folder with some")
    build.add_argument("--cache", type=Path, help="where built packages are kept (default: the user's cache)")
    build.add_argument("--overlay", type=Path, action="append", default=[], help="a prefix with packages they need")
    build.add_argument("--json", action="store_true", help="print one JSON list")
    build.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Build and tell where each package is."""
    built = build_interfaces(args.folder, args.cache, args.overlay)
    if args.json:
        rows = [{"package": b.package, "prefix": str(b.prefix), "seconds": round(b.seconds, 2)} for b in built]
        print(json.dumps(rows, indent=2))
    else:
        for b in built:
            print(f"{b.package:<28} {'cached' if b.cached else f'{b.seconds:5.1f} s'}  {b.prefix}")
    return 0
