"""Imports all SMACH files of folders, one workspace each, and prints how many of their containers come in how well.

    python tools/smach_corpus.py [--preview] [--causes] [--arguments FILE] FOLDER...

The files' construction is run; only for code that is trusted. `--causes` lists why containers aren't exact; a file of
arguments has those of each folder under its name: `tue: {$ROBOT_REAL: "true"}`. The last column is time of processors.
"""

from __future__ import annotations

import argparse
import re
import resource
import sys
from collections import Counter
from pathlib import Path

import yaml

from grip_bt.formats.smach import ImportedFile, import_files

sys.path.remove(str(Path(__file__).resolve().parent))  # what is imported may import its own `packaging`, say

_WIDTHS = "{:<44}{:>6}{:>9}{:>12}{:>7}{:>9}{:>8}{:>7}"


def main() -> None:
    """Import, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--preview", action="store_true", help="run nothing")
    parser.add_argument("--causes", action="store_true", help="list why containers aren't exact")
    parser.add_argument("--arguments", type=Path, help="YAML: folder -> arguments")
    parser.add_argument("--each", action="store_true", help="list the containers that aren't exact")
    args = parser.parse_args()
    print(_WIDTHS.format("folder", "files", "built", "all exact", "exact", "partial", "failed", "cpu s"))
    everything = yaml.safe_load(args.arguments.read_text()) if args.arguments is not None else {}
    causes: Counter[str] = Counter()
    places: dict[str, str] = {}
    for folder in args.folders:
        begun, given = _computed(), everything.get(folder.name, {})
        arguments = {"": given, **{name: each for name, each in given.items() if isinstance(each, dict)}}
        read = list(import_files(sorted(folder.rglob("*.py")), folder, not args.preview, arguments))
        _row(folder.name, [each for each in read if each.containers], _computed() - begun)
        for each in read:
            for container in each.containers:
                for issue in container.issues if container.verdict != "exact" else ():
                    if issue.severity in ("warning", "error"):
                        cause = re.sub(r"`[^`]*`|'[^']*'|\([^)]*:\d+\)", "…", issue.message)[:110]
                        causes[cause] += 1
                        places.setdefault(cause, f"{each.file.relative_to(folder.resolve().parent)}:{issue.line}")
                        if args.each:
                            print("   ", each.file.name, container.title, container.span.line, issue.message[:230])
    for cause, count in causes.most_common() if args.causes else ():
        print(f"{count:>6} × {cause} ({places[cause]})")


def _computed() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _row(name: str, files: list[ImportedFile], seconds: float) -> None:
    counts = Counter(c.verdict for each in files for c in each.containers)
    built = [each for each in files if any(c.verdict != "failed" for c in each.containers)]
    exact = sum(all(c.verdict == "exact" for c in each.containers) for each in files)
    numbers = counts["exact"], counts["partial"], counts["failed"]
    print(_WIDTHS.format(name[:43], len(files), len(built), exact, *numbers, round(seconds)), flush=True)


if __name__ == "__main__":
    main()
