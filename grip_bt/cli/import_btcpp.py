"""`grip import --from btcpp`: a tree of BehaviorTree.CPP 4, and manifests for the node types that it brings along."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.base.files import replace_text
from grip_bt.base.yaml.tree import read_file
from grip_bt.formats.btcpp import ImportedFile, from_xml
from grip_bt.task import model, walking
from grip_bt.task.catalog import Manifest
from grip_bt.task.catalog.manifest import manifest_text

from .import_pytrees import write_task

HEADER = """\
# Made by `grip import --from btcpp` from {origin}, once; it is yours to edit.
# The file says which ports this node has, and not what it does: write the class, a subclass of grip_bt.nodes.Leaf,
# in leaf.py beside this file. Until then a task that uses it can be checked, but not run.
"""


def run(args: argparse.Namespace) -> int:
    """Import one tree; its task goes to a file or to stdout, what to know about it to stderr."""
    if args.execute or args.arguments is not None:
        args.usage_error("--execute and --arguments are for Python code; an XML file is only read")
    text = read_file(args.path)
    around = find_project(args.path)
    bound = around.folder if (around.folder / "grip.yaml").is_file() else args.path.resolve().parent
    catalog = project_catalog(args.output or args.path)
    imported = from_xml(text, catalog, str(args.path), args.path.resolve().parent, bound, args.machine or "")
    for remark in imported.remarks:
        print(remark, file=sys.stderr)
    if args.report:
        print(_report(imported, args.path.name))
        return 0
    write_task(imported.task, args.output, f"{args.path}", "btcpp")
    if imported.manifests:
        _provide(imported.manifests, args.output, args.path.name)
    return 0


def _report(imported: ImportedFile, origin: str) -> str:
    """Return what became of a file, in words."""
    nodes = [node for _, node in walking.walk(imported.task.root)]
    known = sorted({n.node for n in nodes if isinstance(n, model.Leaf)} - {m.id for m in imported.manifests})
    lines = [
        f"{origin}: imported whole, as {imported.task.name!r}: {len(nodes)} nodes,"
        f" {len(imported.task.data)} variables, {len(imported.task.inputs)} inputs",
        f"  in the catalogue:  {', '.join(known) or 'none'}",
        f"  to be provided:    {', '.join(m.id for m in imported.manifests) or 'none'}",
    ]
    return "\n".join(lines)


def _provide(manifests: tuple[Manifest, ...], output: Path | None, origin: str) -> None:
    """Write a manifest for each node type, in a folder of its own among the project's nodes."""
    names = ", ".join(manifest.id for manifest in manifests)
    if output is None:
        print(f"the catalogue doesn't have {names}; with -o, manifests for them are written too", file=sys.stderr)
        return
    project = find_project(output.parent if output.suffix in (".yaml", ".yml") else output)
    for manifest in manifests:
        file = project.folder / (project.file.nodes or "nodes") / manifest.id / "manifest.yaml"
        try:
            if file.exists():
                raise GripError(f"{file} is there and isn't of {manifest.id}; move it")
            file.parent.mkdir(parents=True, exist_ok=True)
            replace_text(file, manifest_text(manifest, HEADER.format(origin=origin)))
        except OSError as error:
            raise GripError(f"{file}: can't be written: {error.strerror or error}") from error
        print(f"wrote {file}", file=sys.stderr)
    print(f"the code of {names} is to be provided: a leaf.py beside each manifest", file=sys.stderr)
