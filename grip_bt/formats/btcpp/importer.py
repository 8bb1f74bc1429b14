"""BehaviorTree.CPP 4's XML -> task. Sub-trees are put in where they are used; what has no exact equivalent is refused.

The file is read several times: first to learn which type each blackboard entry has and which ports have literals, then,
with that known, to write the task.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.issue import Issue
from grip_bt.formats.btcpp.drafts import Board, Variables, key_of
from grip_bt.formats.btcpp.leaves import Document, Model
from grip_bt.formats.imported import Imported, Issues
from grip_bt.formats.names import node_name
from grip_bt.formats.xml_trees import MOST_NODES
from grip_bt.task import dumps, loads, model
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

from .controls import CONTROLS
from .decorators import ACTIONS, DECORATORS, REFUSED, check_attributes, with_conditions
from .drafts import SKIPPED, SUCCEED, Keys, NodeDraft
from .element import ElementReader, Reading, Refused
from .leaves import Leaves, value_of_text

_KNOWN = {**CONTROLS, **DECORATORS, **ACTIONS}
_EXPLICIT = ("Action", "Condition", "Control", "Decorator")
_MOST_READINGS = 5


def from_xml(
    text: str, catalog: Catalog, source: str = "", folder: Path | None = None, bound: Path | None = None, tree: str = ""
) -> Imported:
    """Return the task of a file of BehaviorTree.CPP 4.

    Args:
        text: the file.
        catalog: where known nodes are; `<arm__lift>` is `arm/lift`.
        source: what to call the file in messages.
        folder: where it lies; without it, included files are refused.
        bound: the folder that included files have to lie in; `folder` by default.
        tree: the tree to import, in place of the main one.

    Raises:
        DocumentError: it can't be read.
        ImportRefusedError: parts of it have no exact equivalent; it lists all of them.
    """
    document = Document(source, folder, bound)
    main = document.load(text)
    if tree and tree not in document.trees:
        raise DocumentError(
            f"there is no tree {tree!r}{nearest(tree, document.trees)} (available: {listing(document.trees)})", source
        )
    importer = _Importer(document, catalog)
    for _ in range(_MOST_READINGS):
        before = importer.state()
        made = importer.read(tree or main)
        if importer.state() == before:
            break
    importer.reading.issues.raise_if_refused(source or "<text>")
    return importer.result(made, tree or main)


class _Importer:
    def __init__(self, document: Document, catalog: Catalog):
        self.document = document
        self.leaves = Leaves(catalog, document.models)
        self.variables = Variables()
        self.used: set[str] = set()
        self.reading = Reading(self.node)

    def state(self) -> object:
        """Return what a further reading may come to other results by."""
        types = {name: (v.type, v.has_initial, v.constant) for name, v in self.variables.every.items()}
        return types, dict(self.leaves.settled)

    def read(self, tree: str) -> NodeDraft:
        """Read the tree once, with what was learned before."""
        self.variables = Variables(before=self.variables.every)
        self.reading = Reading(self.node)
        self.used = {tree}
        root = self.document.trees[tree]
        try:
            made = self._root(ElementReader(self.reading, root, Board(self.variables), (tree,)))
        except Refused:
            made = NodeDraft(dict(SUCCEED))
        self.leaves.settle()
        return made

    def _root(self, tree: ElementReader) -> NodeDraft:
        below = tree.element.children
        if len(below) != 1:
            tree.refuse(f"needs one node inside, and has {len(below)}")
        return replace(tree, element=below[0]).attempt()

    def node(self, here: ElementReader) -> NodeDraft:
        """Read a node, and all below it."""
        self.reading.nodes += 1
        if self.reading.nodes > MOST_NODES:
            raise here.element.error(f"more than {MOST_NODES} nodes, with those of sub-trees")
        check_attributes(here)
        tag, id_ = here.element.tag, here.attributes.get("ID", "")
        name = id_ if tag in (*_EXPLICIT, "SubTree") else tag
        if tag == "SubTree":
            made = self._sub_tree(here, name)
        elif name in REFUSED:
            here.refuse(REFUSED[name])
        elif name in _KNOWN:
            reader, ports = _KNOWN[name]
            if wrong := [name for name in _ports(here) if name not in ports]:
                here.refuse(f"has no port {wrong[0]!r}{nearest(wrong[0], ports)} (available: {listing(ports)})")
            made = reader(here)
        else:
            made = self._leaf(here, name)
        made.name = here.attributes.get("name") or name
        return with_conditions(here, made)

    def _leaf(self, here: ElementReader, name: str) -> NodeDraft:
        tag = here.element.tag
        said = self.document.models.get(name, Model(tag if tag in _EXPLICIT else "Action"))
        if here.element.children or said.kind in ("Control", "Decorator"):
            kind = said.kind if said.kind in ("Control", "Decorator") else "node with children"
            here.refuse(f"is a {kind} of your own C++ code; say what it does with BT.CPP's own nodes")
        keys = here.exact(lambda: self.leaves.leaf(name, _ports(here), here.board))
        return NodeDraft(keys, instant=said.kind == "Condition")

    def _sub_tree(self, here: ElementReader, name: str) -> NodeDraft:
        trees = self.document.trees
        if name not in trees:
            here.refuse(f"there is no tree {name!r}{nearest(name, trees)} (available: {listing(trees)})")
        inside = (*here.inside, name)
        if name in here.inside:
            here.refuse(f"the tree {name!r} contains itself ({' > '.join(inside)})")
        self.used.add(name)
        auto = here.attributes.get("_autoremap", "false") in ("true", "1", "True")
        board = Board(self.variables, here.attributes.get("name") or name, here.board, auto)
        model_of = self.document.models.get(name)
        defaults = {k: p.default for k, p in model_of.ports.items() if p.default is not None} if model_of else {}
        for key, text in {**defaults, **_ports(here)}.items():
            outer = key_of(text, key)
            if outer is not None:
                board.names[key] = here.board.variable(outer)
            else:
                board.names[key] = self.variables.new(f"{board.space}_{key}")
                self.variables.every[board.names[key]].initial = text
        return self._root(replace(here, element=trees[name], board=board, inside=inside))

    # --- the task ---

    def result(self, made: NodeDraft, tree: str) -> Imported:
        """Return the task of the last reading."""
        inputs, data = self._declared(_mentioned(made.keys))
        task: dict[str, Any] = {"grip": model.FORMAT_VERSION, "name": node_name(tree)}
        if made.skips:
            task["outcomes"] = {"success": "success", "failure": "failure", SKIPPED: "success"}
        task |= {**({"inputs": inputs} if inputs else {}), **({"data": data} if data else {}), "root": made.keys}
        try:
            catalog = self.leaves.catalog.with_manifests(self.leaves.settled.values())
            read, early = with_nulls(model.Task.model_validate(in_order(task, catalog)), catalog)
            loads(dumps(read))
        except (ValidationError, DocumentError, RecursionError) as error:
            raise DocumentError(f"its task can't be written as a file: {error}", self.document.source) from error
        issues = Issues(self.document.source)
        issues.extend(self.document.issues)
        issues.extend(self.reading.issues)
        for name in (t for t in self.document.trees if t not in self.used):
            issues.add("left-out", f"<BehaviorTree> {name!r}", f"isn't used by {tree!r}, and isn't imported")
        for name in early:
            issues.add("null-at-first", name, "may be read before it is written; it is null until then")
        for name in inputs:
            issues.add("changed", name, "is read and never written; it is an input of the task")
        used = {node.node for _, node in model.walk(read.root) if isinstance(node, model.Leaf)}
        manifests = tuple(m for m in self.leaves.settled.values() if m.id in used)
        for face in self.leaves.faces.values():
            unknown = [port for port, use in face.uses.items() if use.bound and not use.declared]
            if unknown:
                text = f"no <TreeNodesModel> declares the direction of {listing(map(repr, unknown))}"
                issues.add("incomplete", face.name, f"{text}; treated as input and output")
        return Imported({read.name: read}, tuple(issues), manifests=manifests)

    def _declared(self, mentioned: set[str]) -> tuple[dict[str, object], dict[str, object]]:
        inputs: dict[str, object] = {}
        data: dict[str, object] = {}
        for name, entry in self.variables.every.items():
            if name not in mentioned:
                continue  # a literal of a sub-tree that became part of a node
            if entry.has_initial:
                value = entry.initial
                kind = entry.type
                if isinstance(value, str):
                    kind = "str" if kind == "Any" else kind
                    try:
                        value = value_of_text(value, kind)
                    except ValueError as error:
                        message = f"the entry {name!r} holds {value!r}: {error}"
                        raise DocumentError(message, self.document.source) from error
                data[name] = {"type": kind, "value": value}
            elif not entry.known:
                data[name] = {"type": "Any", "value": None}
            elif entry.written or entry.texts:
                data[name] = entry.type
            else:
                inputs[name] = entry.type
        return inputs, data


def _ports(here: ElementReader) -> dict[str, str]:
    return {k: v for k, v in here.attributes.items() if k not in ("name", "ID") and not k.startswith("_")}


def _mentioned(root: Keys) -> set[str]:
    """Return the variables that a node, or one below it, reads or writes."""
    names: set[str] = set()
    for _, node in model.walk(model.Task.model_validate({"grip": 1, "name": "t", "root": root}).root):
        if isinstance(node, model.Leaf):
            names.update(node.in_.values(), node.out.values())
        if isinstance(node, model.ForEach):
            names.add(node.items)
        for _, text in model.expressions_of(node):
            names.update(parse_expression(text).names)
    return names


def with_nulls(task: model.Task, catalog: Catalog) -> tuple[model.Task, list[str]]:
    """Return the task with null in the variables that only ports and Switches read too early, and their names."""
    issues = [issue for issue in validate(task, catalog).issues if issue.code == "read-before-write"]
    nodes = dict(model.walk(task.root))
    patient, strict = set[str](), set[str]()
    for issue in issues:
        names, mild = _read(nodes[issue.path], issue)
        (patient if mild else strict).update(names)
    early = [name for name in task.data if name in patient - strict]
    null = model.Variable(type="Any", value=None)
    data = {name: null if name in early else variable for name, variable in task.data.items()}
    return (task.model_copy(update={"data": FrozenDict(data)}) if early else task), early


def in_order(task: dict[str, Any], catalog: Catalog) -> dict[str, Any]:
    """Return a task's keys with `order: declared` in parallels whose children share variables, as all do in BT.CPP."""
    for issue in validate(model.Task.model_validate(task), catalog).issues:
        if issue.code in ("parallel-writes", "parallel-read-write"):
            keys = task["root"]
            for name in issue.path.split("/") if issue.path != "/" else ():
                keys = keys.get("children", keys.get("child"))[name]
            keys["order"] = "declared"
    return task


def _read(node: model.AnyNode, issue: Issue) -> tuple[Iterable[str], bool]:
    """Return the variables that an issue is about, and whether their reader takes null for nothing."""
    key = issue.key[0] if issue.key else ""
    if isinstance(node, model.Leaf) and key == "in":
        return [node.in_[str(issue.key[1])]], node.node != "flow/compute"
    texts = dict(model.expressions_of(node))
    names = parse_expression(texts[str(key)]).names if key in texts else ()
    return names, key == "on_value" and texts["on_value"] in names
