"""Run somebody's trees of py_trees as they are, and import them; print a table.

    python tools/pytrees_table.py [--ticks N] [--stand-ins] [--path FOLDER ...] WHERE ...

WHERE is what `grip run` takes: `module:function`, `file.py:function` or `file.py`; or a folder, all of whose functions
that look as if they made a tree are tried. This runs their code. For each tree: how many nodes it has; whether it was
ticked N times by the runner, drawn, journalled, and had the same statuses after each tick, or raised the same in one,
as under py_trees alone; and how many of its nodes become kinds and node types of ours when it is imported. Below the
table stands which classes were kept, how often, and why. With `--stand-ins` packages that are missing are stood in for,
in all three.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LIMIT = 60.0
"""How long [s] one tree may take."""
NAMES = ("create_root", "create_tree", "create_bt", "make_bt", "make_tree", "build_tree", "bootstrap")


def candidates(where: str) -> Iterator[tuple[str, str]]:
    """Yield what is run and what is imported of each tree that a folder seems to have.

    A program is run as one, and the function in it that makes its tree is imported. What is no folder names a tree.
    """
    if not Path(where).is_dir():
        yield where, where
        return
    for file in sorted(Path(where).rglob("*.py")):
        text = file.read_text(errors="replace")
        if "py_trees" not in text:
            continue
        try:
            tree = ast.parse(text)
        except SyntaxError:
            continue
        found = [each.name for each in tree.body if isinstance(each, ast.FunctionDef)]
        makers = [f"{file}:{name}" for name in found if name in NAMES or ("create" in name and "tree" in name)]
        if "__main__" in text and "BehaviourTree" in text:
            yield str(file), makers[0] if makers else str(file)
        else:
            yield from ((each, each) for each in makers)


def alone(where: str, ticks: int, stand_ins: bool, told: dict[str, Any]) -> list[Any]:
    """Tick by py_trees alone; return the statuses after each tick, up to one in which a behaviour raises."""
    from grip_bt.nodes.dry_run import dry_run_of_tree
    from grip_bt.nodes.tree_code import find_tree, is_of_ros, place_of

    if stand_ins:
        dry_run = dry_run_of_tree(lambda what: None, place_of(where).file)
        dry_run.__enter__()
    found = find_tree(place_of(where))
    if not found.ready and is_of_ros(found.tree.root):
        from grip_bt.ros.client.connection import TreeNode

        found.tree.setup(node=TreeNode().node)
    elif not found.ready:
        found.tree.setup()
    seen: list[Any] = []
    found.tree.post_tick_handlers.append(lambda tree: seen.append([each.status.name for each in tree.root.iterate()]))
    try:
        for _ in range(ticks):
            found.tree.tick()
    except Exception as error:  # noqa: BLE001 - somebody's behaviour may raise anything
        told["raised"] = type(error).__name__
    return seen


def under_the_runner(where: str, ticks: int, stand_ins: bool, told: dict[str, Any]) -> list[Any]:
    """Tick by the runner, with a journal; return the same."""
    from grip_bt.app.runs.execute import RunOptions, open_session
    from grip_bt.formats.draw import to_svg
    from grip_bt.runtime import JournalReader
    from grip_bt.task.catalog import Catalog

    seen: list[Any] = []
    options = RunOptions(journal=Path("table.sqlite"), ticks=ticks, rate=200.0, stand_ins=stand_ins)
    with open_session(where, options) as session:
        tree: Any = session.runner.compiled
        told["nodes"] = sum(1 for _ in tree.root.iterate())
        told["drawn"] = len(to_svg(session.document.task, Catalog.builtin(), "tree")) > 0
        handlers = tree._found.tree.post_tick_handlers
        handlers.append(lambda tree: seen.append([each.status.name for each in tree.root.iterate()]))
        result = session.runner.run()
        told["ended"] = result.status + (f": {result.error}" if result.error else "")
        run, journal = session.runner.run_id, session.journal
    with JournalReader(journal) as reader:
        told["ends"] = sum(1 for event in reader.events(run) if event.event in ("exit", "interrupted"))
    return seen


def imported(where: str, stand_ins: bool, told: dict[str, Any]) -> None:
    """Import it; count what became what."""
    from grip_bt.formats.pytrees import import_from_code
    from grip_bt.task.model import Foreign, walk

    made = import_from_code(where, Path.cwd(), stand_ins=stand_ins)
    # what stands inside a node that does what one behaviour did counts with it
    kinds = {path: node for path, node in walk(made.task.root) if path.rpartition("/")[2].split()[:1] != ["inside"]}
    why = {issue.path: issue.message for issue in made.issues}
    foreign = {path: node.behaviour for path, node in kinds.items() if isinstance(node, Foreign)}
    kept = [f"{name}: {why.get(path, '').partition(', as ')[0]}" for path, name in foreign.items()]
    told |= {"imported": len(kinds), "kept": len(foreign), "foreign": sorted({*foreign.values()}), "why": kept}


def one(where: str, ticks: int, stand_ins: bool, what: str) -> dict[str, Any]:
    """Return what a process of its own finds out."""
    told: dict[str, Any] = {}
    try:
        if what == "alone":
            told["seen"] = alone(where, ticks, stand_ins, told)
        elif what == "run":
            told["seen"] = under_the_runner(where, ticks, stand_ins, told)
        else:
            imported(where, stand_ins, told)
    except BaseException as error:  # noqa: BLE001 - somebody's code may do anything
        told["error"] = f"{type(error).__name__}: {error}".splitlines()[0]
    return told


def child(where: str, ticks: int, stand_ins: bool, what: str) -> dict[str, Any]:
    """Have it found out, within the limit."""
    command = [sys.executable, "-P", __file__, "--ticks", str(ticks), "--what", what, where]
    command += ["--stand-ins"] if stand_ins else []
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return {"error": f"nothing within {LIMIT:g} s"}
    lines = [line for line in done.stdout.splitlines() if line.startswith('{"told"')]
    return (
        json.loads(lines[-1])["told"]
        if lines
        else {"error": (done.stderr.strip().splitlines() or ["it said nothing"])[-1]}
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("where", nargs="+")
    parser.add_argument("--ticks", type=int, default=10)
    parser.add_argument("--stand-ins", action="store_true", help="stand in for what is missing")
    parser.add_argument("--path", action="append", default=[], help="where their modules are looked for too")
    parser.add_argument("--what", default="", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.what:
        print(json.dumps({"told": one(args.where[0], args.ticks, args.stand_ins, args.what)}), flush=True)
        os._exit(0)
    os.environ["PYTHONPATH"] = os.pathsep.join([*args.path, os.environ.get("PYTHONPATH", "")])
    print("| tree | nodes | runs unchanged | drawn | same statuses | became ours | what is kept, or why not |")
    print("|---|---|---|---|---|---|---|")
    sums, kept = [0, 0, 0, 0, 0], Counter[str]()
    for where, made_by in (each for given in args.where for each in candidates(given)):
        began = time.monotonic()
        run, plain, made = (
            child(made_by if what == "import" else where, args.ticks, args.stand_ins, what)
            for what in ("run", "alone", "import")
        )
        raised = plain.get("raised", "nothing")
        runs = len(run.get("seen", ())) == args.ticks or f" {raised}: " in run.get("ended", "")
        same = runs and run["seen"] == plain.get("seen")
        ours = made.get("imported", 0) - made.get("kept", 0)
        kept.update(made.get("why", ()))
        why = (
            run.get("error")
            or (run["ended"] if run.get("ended", "").startswith("error") else "")
            or made.get("error")
            or ("" if same else plain.get("error", ""))
            or ", ".join(made["foreign"])
        )
        share = f"{ours} of {made['imported']}" if "imported" in made else "-"
        words = ("yes" if said else "no" for said in (runs, run.get("drawn"), same))
        print(f"| {where} | {run.get('nodes', '-')} | {' | '.join(words)} | {share} | {why[:160]} |", flush=True)
        sums = [
            a + b for a, b in zip(sums, (1, runs, bool(run.get("drawn")), ours, made.get("imported", 0)), strict=True)
        ]
        sys.stderr.write(f"{where}: {time.monotonic() - began:.0f} s\n")
    print("\nkept:" if kept else "")
    for what, times in kept.most_common():
        print(f"{times:4} {what}")
    print(
        f"\n{sums[0]} trees: {sums[1]} run unchanged, {sums[2]} drawn; {sums[3]} of {sums[4]} imported nodes are ours"
    )


if __name__ == "__main__":
    main()
