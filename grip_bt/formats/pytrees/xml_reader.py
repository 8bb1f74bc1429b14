"""py_trees' XML -> task. Sub-trees are put in where they are used; what has no equivalent is refused with its line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.common import ParallelPolicy

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.formats.blackboard import Board, Variables, key_of, value_of_text
from grip_bt.formats.btcpp.leaves import leaf_keys
from grip_bt.formats.imported import Imported
from grip_bt.formats.names import distinct, node_name
from grip_bt.formats.xml_trees import DEEPEST, MOST_NODES, Document, Element
from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest

from .classes import convert_behaviour
from .keys import NoEquivalentError

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
    reader = _Reader(catalog, files)
    board = Board(reader.variables).inner("", _given(main))
    keys = reader.node(main.only_child(), board, "/", (main.attributes["ID"],))
    try:
        inputs, data = reader.variables.declared([*reader.variables.every])
    except ValueError as error:
        raise DocumentError(str(error), source) from None
    task = {"grip": model.FORMAT_VERSION, "name": node_name(main.attributes["ID"]), "root": keys}
    task |= {"data": inputs | data} if inputs or data else {}
    made = model.Task.model_validate(task)
    return Imported({made.name: made}, tuple(files.issues))


def _given(element: Element) -> dict[str, str]:
    return {name: text for name, text in element.attributes.items() if name not in ("ID", "name")}


class _Reader:
    def __init__(self, catalog: Catalog, files: Document):
        self.catalog, self.trees, self.issues = catalog, files.trees, files.issues
        self.nodes = 0
        self.variables = Variables()

    def node(self, element: Element, board: Board, path: str, inside: tuple[str, ...]) -> dict[str, Any]:
        """Return the keys of a node and of all below it."""
        while element.tag.lower() in ("subtree", "subtreeplus"):
            element, board, inside = self.sub_tree(element, board, inside)
        self.nodes += 1
        if self.nodes > MOST_NODES or path.count("/") >= DEEPEST:
            raise element.error(f"more than {MOST_NODES} nodes, or {DEEPEST} levels, with all sub-trees")
        for text in element.attributes.values():
            if key_of(text, "") is None and ("{" in text or "}" in text):
                raise element.error(f"{text!r} isn't a key; write {{key}} and nothing else")
        tag = element.tag.lower()
        if tag not in ("sequence", "selector", "fallback", "parallel") and tag not in _OTHERS:
            return self.leaf(element, board)
        try:
            equal = convert_behaviour(self.behaviour(element, board))
        except NoEquivalentError as why:
            raise element.error(str(why)) from None
        if equal.remark:
            self.issues.add("changed", path, equal.remark)
        children, keys = self.children(element, board, path, inside), dict(equal.settings)
        if equal.failures:
            leaves = {name: child["node"] for name, child in children.items() if "node" in child}
            ends = {name: self.catalog.get(id).outcomes for name, id in leaves.items()}
            keys["exits"] = {
                f"{name}.{label}": "failure"
                for name in children
                for label, means in ends.get(name, {"failure": "failure"}).items()
                if means == "failure"
            }
        composite = keys["kind"] in ("sequence", "fallback", "parallel")
        return {**keys, "children" if composite else "child": children}

    def sub_tree(
        self, element: Element, board: Board, inside: tuple[str, ...]
    ) -> tuple[Element, Board, tuple[str, ...]]:
        """Return the root of a sub-tree, its blackboard, and the trees around it."""
        name = element.attributes.get("ID", "")
        if name not in self.trees:
            raise element.error(f"there is no tree {name!r}{nearest(name, self.trees)}")
        if name in inside:
            raise element.error(f"the tree {name!r} holds itself")
        tree, space = self.trees[name], element.attributes.get("name", name)
        return tree.only_child(), board.inner(space, {**_given(tree), **_given(element)}), (*inside, name)

    def children(self, element: Element, board: Board, path: str, inside: tuple[str, ...]) -> dict[str, dict[str, Any]]:
        result = {}
        wanted = [child.attributes.get("name", child.tag) for child in element.children]
        for name, given, child in zip(distinct(wanted), wanted, element.children, strict=True):
            below = model.join(path, name)
            if name != given:
                self.issues.add("renamed", below, f"was called {given!r}")
            result[name] = self.node(child, board, below, inside)
        return result

    def behaviour(self, element: Element, board: Board) -> Behaviour:
        """Return what py_trees makes of a composite or decorator, without its children."""
        tag = element.tag.lower()
        if tag in _OTHERS:
            if tag not in _DECORATORS:
                raise NoEquivalentError(f"{_OTHERS[tag].__name__}: a task read from XML has none")
            given = self.settings(element, board, _DECORATORS[tag])
            element.only_child()
            try:
                return _OTHERS[tag](name="", child=Success(""), **given)
            except TypeError:
                raise element.error(f"needs {listing(_DECORATORS[tag])}") from None
        if tag == "parallel":
            policy = self.settings(element, board, {"policy": "str"}).get("policy", "success_on_one")
            if policy not in _POLICIES:
                raise NoEquivalentError(
                    f"the policy {policy!r}{nearest(policy, _POLICIES)} (available: {listing(_POLICIES)})"
                )
            return composites.Parallel("", _POLICIES[policy]())
        memory = self.settings(element, board, {"memory": "bool"}).get("memory", True)
        return (composites.Sequence if tag == "sequence" else composites.Selector)("", memory)

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

    def leaf(self, element: Element, board: Board) -> dict[str, Any]:
        manifest = self.manifest(element)
        if element.children:
            raise element.error(f"{manifest.id} is a leaf and can't hold other nodes")
        try:
            return leaf_keys(manifest, {k: v for k, v in element.attributes.items() if k != "name"}, board)
        except ValueError as error:
            raise element.error(str(error)) from None

    def manifest(self, element: Element) -> Manifest:
        """Return the node that a tag means."""
        id = element.tag.replace(".", "/")
        if id in self.catalog:
            return self.catalog.get(id)
        by_class = [m for m in self.catalog if m.implementation.rpartition(":")[2] == element.tag]
        if len(by_class) == 1:
            return by_class[0]
        ids = [known.replace("/", ".") for known in self.catalog.ids()]
        raise element.error(f"no node of the catalogue is called so{nearest(element.tag, ids)}")
