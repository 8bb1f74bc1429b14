"""BehaviorTree.CPP 4's XML -> task. Sub-trees are put in where they are used; what has no exact equivalent is refused.

The file is read several times: first to learn which type each blackboard entry has and which ports have literals, then,
with that known, to write the task.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.formats.blackboard import Board, Variables
from grip_bt.formats.imported import Imported, Issues
from grip_bt.formats.names import node_name
from grip_bt.formats.xml_trees import MOST_NODES, Document, Model
from grip_bt.task import dumps, loads, model
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate
from grip_bt.task.validation.analysis import TaskAnalysis
from grip_bt.task.validation.dataflow import DataFlow

from .controls import CONTROLS
from .decorators import ACTIONS, DECORATORS, REFUSED, check_attributes, with_conditions
from .drafts import SKIPPED, SUCCEED, Keys, NodeDraft, controlled
from .leaves import Leaves, leaf_keys
from .reading import ElementReader, Reading, Refused, Unequal

_KNOWN = {**CONTROLS, **DECORATORS, **ACTIONS}
_EXPLICIT = ("Action", "Condition", "Control", "Decorator")
_MOST_READINGS = 5
_LATE = ("RetryUntilSuccessful", "Repeat")
_ASKS_AGAIN = ("ReactiveSequence", "ReactiveFallback", "WhileDoElse", "Parallel", "ParallelAll", "PipelineSequence")
_FAMILY = {"SequenceStar": "SequenceWithMemory", **{f"Switch{n}": "Switch" for n in range(2, 7)}}
"""Tag -> the control node that follows its rules, where that has another name."""


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
    main = document.load(text) if not tree else document.wanted(document.take_text(text), tree)
    importer = Importer(document, Leaves(catalog, document.models), main)
    settle([importer])
    importer.reading.issues.raise_if_refused(source or "<text>")
    return importer.result()


def settle(importers: list[Importer]) -> None:
    """Read the trees until nothing new is learned."""
    for _ in range(_MOST_READINGS):
        before = [importer.state() for importer in importers]
        for importer in importers:
            importer.read()
        if [importer.state() for importer in importers] == before:
            break


class Importer:
    """Makes the task of one tree of a document; `leaves` may be shared with others."""

    def __init__(self, document: Document, leaves: Leaves, tree: str):
        self.document, self.leaves, self.name = document, leaves, tree
        self.made = NodeDraft(dict(SUCCEED))
        self.variables = Variables()
        self.used: set[str] = set()
        self.reading = Reading(self.node)

    def state(self) -> object:
        """Return what a further reading may come to other results by."""
        types = {name: (v.type, v.has_initial, v.constant) for name, v in self.variables.every.items()}
        return types, dict(self.leaves.settled)

    def read(self) -> None:
        """Read the tree once, with what was learned before."""
        self.variables = Variables(before=self.variables.every)
        self.reading = Reading(self.node)
        self.used = {self.name}
        root = self.document.trees[self.name]
        try:
            self.made = ElementReader(self.reading, root, Board(self.variables), (self.name,)).only()
        except Refused as refused:
            self.reading.issues.add("no-equivalent", str(refused.element), str(refused), root.source, root.line)
        self.leaves.settle()

    def node(self, here: ElementReader) -> NodeDraft:
        """Read a node, and all below it."""
        self.reading.nodes += 1
        if self.reading.nodes > MOST_NODES:
            raise here.element.error(f"more than {MOST_NODES} nodes, with those of sub-trees")
        check_attributes(here)
        tag, id_ = here.element.tag, here.attributes.get("ID", "")
        name = id_ if tag in (*_EXPLICIT, "SubTree") else tag
        if name in _ASKS_AGAIN:
            here = replace(here, again=here.element)
        if tag == "SubTree":
            made = self._sub_tree(here, name)
        elif name in REFUSED:
            here.refuse(REFUSED[name])
        elif name in _KNOWN:
            reader, ports = _KNOWN[name]
            if wrong := [name for name in _ports(here) if name not in ports]:
                here.refuse(f"has no port {wrong[0]!r}{nearest(wrong[0], ports)} (available: {listing(ports)})")
            try:
                made = reader(here)
            except Unequal as why:
                made = self._by_its_rules(here, name, why)
        else:
            made = self._leaf(here, name)
        if name in _LATE and here.again is not None:
            text = "after attempts of several ticks the next one begins in the next tick, in BT.CPP in the same one"
            more = "what is around it may be asked once more in between"
            here.note("changed", f"<{name}> is below: {text}; {more}", here.again)
        made.name = here.attributes.get("name") or name
        return with_conditions(here, made)

    def _leaf(self, here: ElementReader, name: str) -> NodeDraft:
        tag = here.element.tag
        said = self.document.models.get(name, Model(tag if tag in _EXPLICIT else "Action"))
        controls = bool(here.element.children)
        if said.kind in ("Control", "Decorator") and not controls:
            here.refuse(f"is a {said.kind} and has no children")
        keys = here.exact(lambda: self.leaves.leaf(name, _ports(here), here.board, controls))
        if not controls:
            return NodeDraft(keys, instant=said.kind == "Condition")
        return controlled(NodeDraft(keys), here.children(), here.meaning)

    def _by_its_rules(self, here: ElementReader, name: str, why: Unequal) -> NodeDraft:
        """Return a control node that follows BT.CPP's rules of a node where no kind does."""
        id_ = f"btcpp/{_FAMILY.get(name, name)}"
        if id_ not in self.leaves.catalog:
            raise why
        if str(why):
            here.note("changed", f"{why}; it became a `control` that follows BehaviorTree.CPP's own rules")
        children = list(here.read) or here.children()
        keys = here.exact(lambda: leaf_keys(self.leaves.catalog.get(id_), _ports(here), here.board))
        skips = "SKIPPED" in here.attributes.get("if_empty", "") or name == "SkipUnlessUpdated"
        return controlled(NodeDraft(keys, skips), children, here.meaning)

    def _sub_tree(self, here: ElementReader, name: str) -> NodeDraft:
        trees = self.document.trees
        if self.document.tree(name, here.element) is None:
            here.refuse(f"there is no tree {name!r}{nearest(name, trees)} (available: {listing(trees)})")
        inside = (*here.inside, name)
        if name in here.inside:
            here.refuse(f"the tree {name!r} contains itself ({' > '.join(inside)})")
        self.used.add(name)
        auto = here.attributes.get("_autoremap", "false") in ("true", "1", "True")
        said = self.document.models.get(name, Model(""))
        given = {key: port.default for key, port in said.ports.items() if port.default is not None} | _ports(here)
        board = here.board.inner(here.attributes.get("name") or name, given, auto)
        return here.at(trees[name], board=board, inside=inside).only()

    # --- the task ---

    def result(self) -> Imported:
        """Return the task of the last reading. Raises DocumentError: its task can't be written as a file."""
        made, tree = self.made, self.name
        try:
            inputs, data = self.variables.declared(_mentioned(made.keys))
        except ValueError as error:
            raise DocumentError(str(error), self.document.source) from error
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
            text = "may be read before it is written, where BT.CPP ends with an error; it is null until then"
            issues.add("null-at-first", name, text)
        for name in inputs:
            issues.add("changed", name, "is read and never written; it is an input of the task")
        used = {node.node for _, node in model.walk(read.root) if isinstance(node, model.Leaf)}
        known = self.leaves.catalog
        settled = [m for m in self.leaves.settled.values() if m.id in used]
        manifests = tuple(m for m in settled if m.id not in known or known.get(m.id) != m)
        for face in self.leaves.faces.values():
            unknown = [port for port, use in face.uses.items() if use.bound and not use.declared]
            if unknown and face.id in used:
                text = f"no <TreeNodesModel> declares the direction of {listing(map(repr, unknown))}"
                issues.add("incomplete", face.name, f"{text}; treated as input and output")
        return Imported({read.name: read}, tuple(issues), manifests=manifests)


def _ports(here: ElementReader) -> dict[str, str]:
    said = {k: v for k, v in here.attributes.items() if k not in ("name", "ID") and not k.startswith("_")}
    if here.element.tag in ("SkipUnlessUpdated", "WaitValueUpdate", "WasEntryUpdated") and "entry" in said:
        said["entry"] = "{" + said["entry"].strip("{}") + "}"  # a key needs no braces there
    return said


def _mentioned(root: Keys) -> set[str]:
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
    """Return the task with null in the variables that are read too early, and their names."""
    null, early = model.Variable(type="Any", value=None), dict[str, None]()
    while new := {n for n in DataFlow(TaskAnalysis(task, catalog)).missing.values() if n in task.data} - early.keys():
        early |= dict.fromkeys(name for name in task.data if name in new)
        data = {name: null if name in new else variable for name, variable in task.data.items()}
        task = task.model_copy(update={"data": FrozenDict(data)})
    return task, list(early)


def in_order(task: dict[str, Any], catalog: Catalog) -> dict[str, Any]:
    """Return a task's keys with `order: declared` in parallels whose children share variables, as all do in BT.CPP."""
    for issue in validate(model.Task.model_validate(task), catalog).issues:
        if issue.code in ("parallel-writes", "parallel-read-write"):
            keys = task["root"]
            for name in issue.path.split("/") if issue.path != "/" else ():
                keys = keys.get("children", keys.get("child"))[name]
            keys["order"] = "declared"
    return task
