"""py_trees' XML -> task and back; what has no equivalent is refused with its line, or its path.

Sub-trees are put in where they are used. py_trees builds the tree of a file that was written here when it is given a
class for each leaf's tag, which is its catalogue id with a dot for the slash: `<arm.lift>`.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.common import ParallelPolicy

from grip_bt.base.errors import DocumentError, NotExpressibleError, listing, nearest
from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.formats.blackboard import Board, Variables, key_of, text_of_value, value_of_text
from grip_bt.formats.btcpp.leaves import leaf_keys
from grip_bt.formats.imported import Imported
from grip_bt.formats.names import node_name
from grip_bt.formats.xml_trees import (
    DEEPEST,
    MOST_NODES,
    Document,
    Element,
    comment,
    leaf_attributes,
    require_expressible,
    xml_element,
    xml_text,
)
from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest

from .classes import SAID, NodeSettings, class_for, convert_behaviour
from .tree import Reader, imported

_POLICIES: dict[str, Callable[[], ParallelPolicy.Base]] = {
    "success_on_all": ParallelPolicy.SuccessOnAll,
    "success_on_one": ParallelPolicy.SuccessOnOne,
}
_PLAIN = ("Inverter", "FailureIsSuccess", "SuccessIsFailure", "PassThrough", "Count", "SuccessIsRunning")
_DECORATORS: dict[str, dict[str, str]] = {
    "retry": {"num_failures": "int"},
    "repeat": {"num_success": "int"},
    "timeout": {"duration": "float"},
    **{name.lower(): {} for name in (*_PLAIN, "FailureIsRunning", "RunningIsFailure")},
}
"""Tag -> the types of its attributes."""
_OTHERS = {n.lower(): c for n, c in vars(decorators).items() if isinstance(c, type) and issubclass(c, Behaviour)}


def from_xml(text: str, catalog: Catalog, source: str = "", folder: Path | None = None) -> Imported:
    """Return the task of a file of py_trees' XML.

    A leaf's tag is a catalogue id with a dot for the slash (`<arm.lift>`), or the name of the class that one node of
    the catalogue is implemented by. Each blackboard key becomes a variable of the task; its type is that of the ports
    which write it, or else of those that read it.

    Args:
        text: the file.
        catalog: where the leaves' manifests are.
        source: what to call the file in messages.
        folder: where included files are looked for, and no further up; without it they are refused.

    Raises:
        DocumentError: it can't be read, or holds something that has no equivalent in a task.
    """
    files = Document(source, folder, btcpp=False)
    main = files.trees[files.load(text)]
    builder, variables = _Builder(catalog, files.trees), Variables()
    board = Board(variables).inner("", _given(main))
    root = builder.built(main.only_child(), board, (main.attributes["ID"],), 0)
    try:
        inputs, data = variables.declared([*variables.every])
    except ValueError as error:
        raise DocumentError(str(error), source) from None
    declared = {"data": inputs | data} if inputs or data else {}
    made = imported(_Reader(whole=False), root, node_name(main.attributes["ID"]), declared)
    return replace(made, issues=(*files.issues, *made.issues))


def _given(element: Element) -> dict[str, str]:
    return {name: text for name, text in element.attributes.items() if name not in ("ID", "name")}


class _Reader(Reader):
    def other(self, behaviour: Any, path: str) -> NodeSettings:
        return NodeSettings(behaviour.keys) if hasattr(behaviour, "keys") else convert_behaviour(behaviour)


class _Builder:
    """Makes the tree of a file as py_trees does."""

    def __init__(self, catalog: Catalog, trees: dict[str, Element]):
        self.catalog, self.trees = catalog, trees
        self.nodes = 0

    def built(self, element: Element, board: Board, inside: tuple[str, ...], depth: int) -> Behaviour:
        name = element.attributes.get("name", element.tag)
        while element.tag.lower() in ("subtree", "subtreeplus"):
            wanted = element.attributes.get("ID", "")
            if wanted not in self.trees:
                raise element.error(f"there is no tree {wanted!r}{nearest(wanted, self.trees)}")
            if wanted in inside:
                raise element.error(f"the tree {wanted!r} holds itself")
            tree, space = self.trees[wanted], element.attributes.get("name", wanted)
            board, inside = board.inner(space, {**_given(tree), **_given(element)}), (*inside, wanted)
            element = tree.only_child()
        self.nodes += 1
        if self.nodes > MOST_NODES or depth > DEEPEST:
            raise element.error(f"more than {MOST_NODES} nodes, or {DEEPEST} levels, with all sub-trees")
        for text in element.attributes.values():
            if key_of(text, "") is None and ("{" in text or "}" in text):
                raise element.error(f"{text!r} isn't a key; write {{key}} and nothing else")
        tag = element.tag.lower()
        if tag not in ("sequence", "selector", "fallback", "parallel") and tag not in _OTHERS:
            return self.leaf(element, board, name)
        children = [self.built(child, board, inside, depth + 1) for child in element.children]
        if tag in _OTHERS:
            if tag not in _DECORATORS:
                raise element.error(f"{_OTHERS[tag].__name__}: a task read from XML has none")
            given = self.settings(element, board, _DECORATORS[tag])
            element.only_child()
            try:
                return _OTHERS[tag](name=name, child=children[0], **given)
            except TypeError:
                raise element.error(f"needs {listing(_DECORATORS[tag])}") from None
        if tag == "parallel":
            policy = self.settings(element, board, {"policy": "str"}).get("policy", "success_on_one")
            if policy not in _POLICIES:
                near = f"{nearest(policy, _POLICIES)} (available: {listing(_POLICIES)})"
                raise element.error(f"the policy {policy!r}{near}")
            return composites.Parallel(name, _POLICIES[policy](), children)
        memory = self.settings(element, board, {"memory": "bool"}).get("memory", True)
        return (composites.Sequence if tag == "sequence" else composites.Selector)(name, memory, children)

    def settings(self, element: Element, board: Board, types: dict[str, str]) -> dict[str, Any]:
        """Return the attributes of a composite or decorator; py_trees ignores unknown ones, here they are errors."""
        found = {}
        for name, text in element.attributes.items():
            if name == "name":
                continue
            if name not in types:
                there = listing([*types, "name"])
                raise element.error(f"no attribute {name!r}{nearest(name, types)} (available: {there})")
            if (key := key_of(text, name)) is not None:
                if not board.entry(key).constant:
                    raise element.error(f"{name}={text!r} is a variable; it has to be a constant here")
                text = board.entry(key).initial
            try:
                found[name] = value_of_text(text, types[name])
            except ValueError as error:
                raise element.error(f"{name}: {error}") from None
        return found

    def leaf(self, element: Element, board: Board, name: str) -> Behaviour:
        manifest = self.manifest(element)
        if element.children:
            raise element.error(f"{manifest.id} is a leaf and can't hold other nodes")
        try:
            keys = leaf_keys(manifest, {k: v for k, v in element.attributes.items() if k != "name"}, board)
        except ValueError as error:
            raise element.error(str(error)) from None
        made: Any = Success(name)  # it holds the place of the leaf
        made.keys, made.ends = keys, manifest.outcomes
        return made

    def manifest(self, element: Element) -> Manifest:
        id = element.tag.replace(".", "/")
        if id in self.catalog:
            return self.catalog.get(id)
        by_class = [m for m in self.catalog if m.implementation.rpartition(":")[2] == element.tag]
        if len(by_class) == 1:
            return by_class[0]
        ids = [known.replace("/", ".") for known in self.catalog.ids()]
        raise element.error(f"the catalogue has no such node{nearest(element.tag, ids)}")


_TARGET, _HIDDEN = "py_trees' XML", "__DOT__"
"""`_HIDDEN` is what py_trees writes for a dot in a constant; a text that holds it would come back changed."""
_FIELDS: dict[type, tuple[str, ...]] = {
    model.Leaf: ("node", "with_", "in_", "out"),
    model.Parallel: ("policy", "cancel"),
    **SAID,
}


def to_xml(task: model.Task, catalog: Catalog) -> str:
    """Return a file that py_trees 2.6 reads as the tree of a task.

    Args:
        task: the document. `doc` becomes comments; free data (`x-*`) isn't written.
        catalog: where the leaves' manifests are.

    Raises:
        InvalidTaskError: the task is wrong.
        NotExpressibleError: the XML has no words for a part of it.
    """
    resolved = resolve(task, catalog)
    _check_task(resolved)
    root = ET.Element("root", main_tree_to_execute=task.name)
    root.extend(comment(task.doc))
    tree = ET.SubElement(root, "BehaviorTree", ID=task.name)
    tree.extend(comment(task.root.doc))
    tree.append(xml_element(resolved.root, _element, comments=True))
    return xml_text(root)


def _text(value: object, type_name: str) -> str:
    text = text_of_value(value, type_name, as_json=False)
    if _HIDDEN in text or "{" in text or "}" in text:
        raise ValueError(f"{value!r} would come back as something else")
    return text


def _check_task(resolved: Resolved) -> None:
    task = resolved.task
    try:
        _text(task.name, "str")
    except ValueError as error:
        raise NotExpressibleError("/", f"the task's name ({error})", _TARGET) from error
    if dict(task.outcomes) != {"success": "success", "failure": "failure"} or any(
        target != label for (_, label, _), target in resolved.ends
    ):
        raise NotExpressibleError("/", "a task with outcomes of its own", _TARGET)
    for name, variable in task.data.items():
        if not isinstance(variable, str) and variable.has_value:
            raise NotExpressibleError("/", f"the initial value of the variable {name!r}", _TARGET)


def _element(part: Part) -> tuple[str, dict[str, str]]:
    node = part.node
    fields = _FIELDS.get(type(node))
    require_expressible(part.path, node, fields if fields is None else (*fields, "on", "x", "exits"), _TARGET)
    if not isinstance(node, model.Parallel) and part.exits:
        raise NotExpressibleError(part.path, "`exits`", _TARGET)
    tag, attributes = _tag_of(part, node)
    return tag, {"name": part.name, **attributes}


def _tag_of(part: Part, node: model.AnyNode) -> tuple[str, dict[str, str]]:
    match node:
        case model.Leaf() if both := node.in_.keys() & node.out.keys():
            what = f"{min(both)!r}, which is more than one port or parameter,"
        case model.Leaf():
            return node.node.replace("/", "."), leaf_attributes(part, node, _text, _TARGET)
        case model.Parallel():
            return "Parallel", {"policy": _policy(part, node)}
        case model.Timeout(child_first=False):
            what = "a timeout that looks at the clock before its child (py_trees' looks after it: `child_first: true`)"
        case _ if found := class_for(node):
            return found[0], {name: str(value).lower() for name, value in found[1].items()}
        case _:
            what = "a guard"
    raise NotExpressibleError(part.path, what, _TARGET)


def _policy(part: Part, node: model.Parallel) -> str:
    if (node.policy, node.cancel) == ("all", "halt") and not part.exits:
        return "success_on_all"
    # py_trees' other policy fails with the first child that fails, which is an exit here.
    failing = {
        ((child.name, label, None), "failure")
        for child in part.children
        for label, means in child.meaning.items()
        if means == "failure"
    }
    if (node.policy, node.cancel) == ("any", "halt") and set(part.exits) == failing:
        return "success_on_one"
    raise NotExpressibleError(part.path, "this parallel, which matches no py_trees policy,", _TARGET)
