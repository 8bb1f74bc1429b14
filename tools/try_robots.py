"""Try public robots: a table of which configurations below some folders load, and run on fakes and in simulation.

    python tools/try_robots.py [--sim] [--all] [--json FILE] FOLDER...

A FOLDER is a workspace, a repository or a package. Of each repository (the folder below `src`, or FOLDER itself) one
configuration package is tried, or with `--all` each; for each, `grip robot check`, `grip new --robot` and
`grip run tasks/first.yaml` are what a user would type. Nothing is downloaded.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.commanders.description.configurations import configured_packages
from grip_bt.task import load
from grip_bt.task.model import children_of

TIME = 600.0
"""After so long a try is over [s]."""
MARKS = ("loads", "fake", "sim", "pose", "line")


def packages_of(folder: Path) -> list[Path]:
    """Return the packages to be tried of a folder."""
    return configured_packages(folder) or [folder]


def repository_of(package: Path) -> str:
    """Return the repository that a package lies in: what is below `src`, else its folder's name."""
    parts = package.resolve().parts
    return parts[parts.index("src") + 1] if "src" in parts[:-1] else package.parent.name


def tried(package: Path, sim: bool) -> dict[str, object]:
    """Return what became of one package."""
    deadline = time.monotonic() + TIME

    def grip(*words: str) -> str:
        left = deadline - time.monotonic()
        command = [sys.executable, "-m", "grip_bt.cli", *words]
        done = subprocess.run(command, capture_output=True, text=True, timeout=left)
        said.append((done.stderr.strip() or "no output").splitlines()[-1])
        return done.stdout

    said: list[str] = []
    runs: dict[str, dict[str, Any]] = {}
    nodes: list[str] = []
    try:
        findings = json.loads(grip("robot", "check", str(package), "--json"))["findings"]
        errors = [finding for finding in findings if finding["severity"] == "error"]
        if not errors:
            with TemporaryDirectory(prefix="grip_robot_") as lab:
                grip("new", f"{lab}/lab", "--robot", str(package))
                task = Path(lab, "lab", "tasks", "first.yaml")
                nodes = list(children_of(load(task).root))
                for on in ("fake", *(["sim"] if sim else [])):
                    runs[on] = json.loads(grip("run", str(task), "--robot", on, "--json"))
    except subprocess.TimeoutExpired:
        return {"loads": False, "why": f"not over after {TIME:g} s"}
    except (json.JSONDecodeError, GripError):
        return {"loads": False, "why": said[-1]}
    failed = [run["message"] for run in runs.values() if run["status"] != "success"]
    why = errors[0]["message"] if errors else failed[0] if failed else ""
    return {
        "loads": not errors,
        "warnings": len(findings) - len(errors),
        **{on: run["status"] == "success" for on, run in runs.items()},
        "pose": any(node.endswith("_pose") for node in nodes),
        "line": any(node.endswith("_line") for node in nodes),
        "nodes": nodes,
        "why": why,
    }


def main() -> int:
    """Print a row for each package, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--sim", action="store_true", help="run in simulation, too")
    parser.add_argument("--all", action="store_true", help="every package, not one of each repository")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a line of JSON for each package there, too")
    args = parser.parse_args()
    seen, rows = set(), []
    print("| repository | package | loads | fake | sim | pose | line | warnings | what is left |\n" + "|---" * 9 + "|")
    for package in (package for folder in args.folders for package in packages_of(folder.resolve())):
        repository = repository_of(package)
        if repository in seen and not args.all:
            continue
        seen.add(repository)
        row = {"repository": repository, "package": package.name, **tried(package, args.sim)}
        rows.append(row)
        marks = " | ".join("yes" if row.get(key) else "no" if key in row else "" for key in MARKS)
        why = " ".join(str(row["why"]).split())[:160].replace("|", "/")
        print(f"| {repository} | {package.name} | {marks} | {row.get('warnings', '')} | {why} |", flush=True)
        if args.json is not None:
            with args.json.open("a") as file:
                file.write(json.dumps(row) + "\n")
    sums = (f"{key} {sum(bool(row.get(key)) for row in rows)}" for key in MARKS)
    print(f"\n{len(rows)} packages: {', '.join(sums)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
