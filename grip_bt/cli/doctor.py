"""`grip doctor`: whether everything is installed, and the command that fixes what isn't."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from grip_bt.app.project.doctor import Finding, examine

_MARK = {"ok": "ok  ", "missing": "MISS", "broken": "FAIL"}


def add_doctor(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the findings; 1 when something that the demo needs is missing."""
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
        print(f"      {'':<12} fix: {finding.remedy}")
