"""`grip doctor`: what this machine can do, and the command that mends what it can't."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the verbs are listed without loading what they run
    from grip_bt.app.project.doctor import Finding

_MARK = {"ok": "ok  ", "missing": "MISS", "broken": "FAIL"}


def add_parser(subparsers: Any) -> None:
    """Add the verb."""
    parser = subparsers.add_parser("doctor", help="what this machine can do, and how to mend what it can't")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the findings; 1 when something that the demo needs is missing."""
    from grip_bt.app.project.doctor import examine

    findings = examine()
    if args.json:
        print(json.dumps([asdict(f) for f in findings], indent=2))
    else:
        for finding in findings:
            _show(finding)
    return int(any(f.state != "ok" and f.needed for f in findings))


def _show(finding: Finding) -> None:
    print(f"{_MARK[finding.state]}  {finding.part:<12} {finding.detail}")
    if finding.state != "ok" and finding.remedy:
        print(f"      {'':<12} to mend it: {finding.remedy}")
