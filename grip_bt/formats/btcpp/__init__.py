"""BehaviorTree.CPP 4's XML, in and out: what it can say of a task, exactly, and nothing else."""

from __future__ import annotations

from dataclasses import replace

from grip_bt.base.yaml.tree import read_file
from grip_bt.formats.imported import Imported, Request
from grip_bt.task.catalog.manifest import manifest_text

from .importer import from_xml
from .writer import to_xml

__all__ = ["from_xml", "read", "to_xml"]

_HEADER = """\
# Made by `grip import --from btcpp` from {origin}, once; it is yours to edit.
# The file says which ports this node has, and not what it does: write the class, a subclass of grip_bt.nodes.Leaf,
# in leaf.py beside this file. Until then a task that uses it can be checked, but not run.
"""


def read(request: Request) -> Imported:
    """Return the task of an XML file, with a manifest for each node type that the catalogue doesn't have.

    Raises:
        GripError: it can't be read, or parts of it have no exact equivalent.
    """
    folder = request.path.resolve().parent
    text = read_file(request.path)
    made = from_xml(text, request.catalog(), str(request.path), folder, request.bound, request.select)
    header = _HEADER.format(origin=request.path.name)
    files = {f"nodes/{each.id}/manifest.yaml": manifest_text(each, header) for each in made.manifests}
    advice = [f"write the code of {each.id}: leaf.py beside its manifest" for each in made.manifests]
    return replace(made, files=files, advice=tuple(advice))
