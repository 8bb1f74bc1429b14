"""BehaviorTree.CPP 4's XML, in and out: what it can say of a task, exactly, and nothing else.

Files of a project become tasks, and what has to be written for them: manifests, code, mocks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.yaml.tree import read_file
from grip_bt.codegen.render import template
from grip_bt.formats.btcpp.importer import Importer, from_xml, settle
from grip_bt.formats.btcpp.leaves import Leaves
from grip_bt.formats.btcpp.writer import to_xml
from grip_bt.formats.imported import Imported, Issues, Item, Request, generated_by
from grip_bt.formats.names import free, node_name
from grip_bt.formats.xml_trees import Document, Library, subtrees_of, workspace_of, xml_files
from grip_bt.task import Task
from grip_bt.task.catalog import Manifest
from grip_bt.task.catalog.manifest import manifest_text

__all__ = ["from_xml", "read", "to_xml"]


_HEADER = f"""\
# {generated_by("btcpp")} from {{origin}}, once; it is yours to edit. Another import adds ports that it lacks.
# The file says which ports this node has; what it does stands in leaf.py beside it, or should.
"""


def read(request: Request) -> Imported:
    """Return the tasks of an XML file, of several, or of a folder, with what is to be written; see `Project.tasks`."""
    project = Project(request)
    made = project.tasks(alone=[request.path] == project.files)
    return replace(made, **project.to_write(made.manifests))


class Project:
    """The files of one import, whose node types are known to all of them."""

    def __init__(self, request: Request):
        self.request, self.catalog = request, request.catalog()
        paths = [request.path, *request.more]
        found = (file for path in paths for file in (xml_files(path) if path.is_dir() else [path]))
        self.files = list(dict.fromkeys(found))
        self.leaves = Leaves(self.catalog, {})
        home = request.path.resolve()
        self.library = Library(workspace_of(home))
        around = [self.library.root, *([request.bound] if request.bound is not None else ())]
        self.bound = min(around, key=lambda folder: len(folder.parts))
        if self.bound == home.parent:  # nothing says where it ends: `../common/parts.xml` belongs to it too
            self.bound = home.parent.parent

    def tasks(self, alone: bool) -> Imported:
        """Return the tasks: one for each main tree, or for each tree that no other one holds.

        Args:
            alone: whether it is one file, which has to come in whole.

        Raises:
            GripError: there is none, or that one can't be read or has no exact equivalent.
        """
        select, items, documents = self.request.select, list[Item](), []
        for file in self.files:
            text = read_file(file) if alone else self.library.text(file)
            if alone or "<BehaviorTree" in text or "<TreeNodesModel" in text:
                document = Document(str(file), file.resolve().parent, self.bound, self.library)
                document.models = self.leaves.models
                try:
                    documents.append((document, document.take_text(text)))
                except GripError as error:
                    if alone:
                        raise
                    items.append(_failed(file.stem, document.source, error))
        for beside in sorted(self.files[0].resolve().parent.glob("*.xml")) if alone else ():
            text = self.library.text(beside)
            if "<TreeNodesModel" in text and "<BehaviorTree" not in text:
                documents[0][0].take_models(text, beside)
        importers: list[Importer] = []
        used = {name for document, _ in documents for tree in document.trees.values() for name in subtrees_of(tree)}
        for document, root in documents:
            mains = [document.wanted(root, select)] if alone and select else []
            if not mains and (alone or document.trees):
                said = alone or "main_tree_to_execute" in root.attributes
                mains = [m for m in document.mains(root) if (m == select if select else said or m not in used)]
            importers += [Importer(document, self.leaves, main) for main in mains]
        settle(importers)
        if not importers and not items:
            raise GripError(f"{self.request.path}: no XML file with a <BehaviorTree> to import")
        made = [(i, each) for i in importers if (each := self._result(i, items, alone)) is not None]
        return replace(_together(made), items=tuple(sorted(items, key=lambda item: item.source)))

    def _result(self, importer: Importer, items: list[Item], alone: bool) -> Imported | None:
        name, source = importer.name, importer.document.source
        line, issues = importer.document.trees[name].line, importer.reading.issues.errors
        if alone:
            importer.reading.issues.raise_if_refused(source)
            return importer.result()
        result = None
        if not issues:
            try:
                result = importer.result()
                issues, result = result.issues, replace(result, issues=())
            except DocumentError as error:
                issues = _failed(name, source, error).issues
        items.append(Item(name, source, line, issues))
        return result

    def to_write(self, manifests: Iterable[Manifest]) -> dict[str, Any]:
        """Return the files that go with the tasks, and what somebody has to do."""
        origin, stem, files, mocks, new = self.request.path.name, self.request.path.stem, {}, "", []
        for each in manifests:
            where, _, name = each.implementation.rpartition(":")
            face = each.model_copy(update={"implementation": f"{Path(where).name}:{name}"})
            files[f"nodes/{each.id}/manifest.yaml"] = manifest_text(face, _HEADER.format(origin=origin))
            if each.id not in self.catalog:
                controls = "skipped" in each.outcomes
                ports = ", ".join(dict.fromkeys((*each.parameters, *each.inputs, *each.outputs)))
                code = template(__package__, "control.py.j2" if controls else "leaf.py.j2")
                if not (self.request.nodes / each.id / "leaf.py").exists():
                    said = f"Ports: {ports}." if ports else "It has no ports."
                    files[f"nodes/{each.id}/leaf.py"] = code.render(name=name, ports=said)
                mocks += "" if controls else f"  {each.id}: {_mock(each)}\n"
                new.append(each.id)
        advice = [f"write the code of {', '.join(new)}: leaf.py beside the manifest"] if new else []
        if mocks:
            head = f"# {generated_by('btcpp')} from {origin}: what nodes without code may do, by their type.\n"
            files[f"mocks/{stem}.yaml"] = f"{head}mocks:\n{mocks}"
            advice.append(f"until then: grip run TASK --mocks mocks/{stem}.yaml")
        return {"files": files, "advice": tuple(advice)}


def _mock(manifest: Manifest) -> str:
    empty = {"int": "0", "float": "0.0", "bool": "false", "str": '""'}
    outputs = ", ".join(f"{port}: {empty.get(out.type, 'null')}" for port, out in manifest.outputs.items())
    return f"{{outcome: success, outputs: {{{outputs}}}}}" if outputs else "success"


def _failed(name: str, source: str, error: GripError) -> Item:
    issues = Issues(source)
    issues.add("unreadable", name, str(error))
    return Item(name, source, 1, tuple(issues))


def _together(made: list[tuple[Importer, Imported]]) -> Imported:
    tasks: dict[str, Task] = {}
    manifests = {each.id: each for _, one in made for each in one.manifests}
    for name, (_, one) in zip(_names([importer for importer, _ in made]), made, strict=True):
        tasks[free(name, tasks)] = one.task
    issues = tuple(dict.fromkeys(issue for _, one in made for issue in one.issues))
    return Imported(tasks, issues, manifests=tuple(manifests.values()))


def _names(importers: list[Importer]) -> list[str]:
    """Name each after its tree; where several trees are called the same, such as MainTree, after its file."""
    files = [Path(each.document.source).resolve() for each in importers]
    told = [
        (each.name, file.stem, f"{file.stem}_{each.name}", f"{file.parent.name}_{file.stem}")
        for each, file in zip(importers, files, strict=True)
    ]
    counts = [Counter(alike) for alike in zip(*told, strict=True)]
    return [
        node_name(next((name for name, count in zip(names, counts, strict=True) if count[name] == 1), names[0]))
        for names in told
    ]
