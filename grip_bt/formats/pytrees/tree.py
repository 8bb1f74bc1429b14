"""Walking a tree of behaviours and writing the task that does the same."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Mapping
from typing import Any

from py_trees.behaviour import Behaviour

from grip_bt.compilers.to_tree import CompiledTree
from grip_bt.formats.imported import Imported, Issues
from grip_bt.formats.names import distinct, node_name
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.node import Node
from grip_bt.task import model

from .classes import ENDS, NodeSettings, NoEquivalentError, convert_behaviour, from_document, is_known, refuse_variables

_PLAIN = {"success": "success", "failure": "failure"}
_COMPOSITES = {name for name, kind in model.KINDS.items() if "children" in kind.model_fields}


def to_task(tree: CompiledTree | Behaviour, name: str = "") -> Imported:
    """Return the task of a tree.

    A compiled task gives its own document back, with what was changed on its behaviours since: nodes added, removed
    or moved, settings changed. Any other tree is read class by class; a behaviour that has no equivalent in a task is
    refused, never approximated.

    Args:
        tree: a compiled task, or the root of any py_trees tree.
        name: the task's name; by default the document's, or the root's.

    Raises:
        ImportRefusedError: behaviours have no equivalent; the error names each with its path and the reason.
    """
    reader = Reader(whole=isinstance(tree, CompiledTree))
    root = tree.root if isinstance(tree, CompiledTree) else tree
    keys = reader.node(root, "/")
    reader.issues.raise_if_refused("the tree")
    if isinstance(tree, CompiledTree):
        task = tree.task.model_dump(by_alias=True, exclude_unset=True, exclude={"root"})
    else:
        meaning = dict(getattr(root, "meaning", _PLAIN))
        task = {"grip": model.FORMAT_VERSION, "name": node_name(root.name)}
        task |= {"outcomes": meaning} if meaning != _PLAIN else {}
    task |= {"root": keys, **({"name": name} if name else {})}
    made = model.Task.model_validate(task)
    return Imported({made.name: made}, tuple(reader.issues))


class Reader:
    """Reads behaviours, one by one; `whole`: they are those of a task, which declares all variables."""

    def __init__(self, whole: bool):
        self.whole = whole
        self.issues = Issues()

    def node(self, behaviour: Behaviour, path: str) -> dict[str, Any]:
        """Return the keys of a node and of all below it."""
        equal = self.equal(behaviour, path)
        keys = dict(equal.settings)
        if equal.remark:
            self.issues.add("changed", path, equal.remark)
        if keys.get("kind") in ("foreign", "subtask"):
            return keys  # what is below stands elsewhere
        children = self.children(behaviour, path)
        if equal.failures:
            keys["exits"] = {
                f"{name}.{label}": "failure"
                for (name, below), child in zip(children.items(), behaviour.children, strict=True)
                for label, means in _ends(child, below).items()
                if means == "failure"
            }
        if equal.selected:
            keys["rules"] = _rules(behaviour, children, equal.selected)
        if "node" in keys:
            return keys
        return {**keys, "children" if keys["kind"] in _COMPOSITES else "child": children}

    def equal(self, behaviour: Behaviour, path: str) -> NodeSettings:
        """Return what one behaviour is; what has no equivalent is noted, so that all of them are found."""
        try:
            if isinstance(behaviour, Node):
                document = behaviour.kind if isinstance(behaviour, KindNode) else behaviour.document
                if document is None:
                    raise NoEquivalentError(f"a {type(behaviour).__name__} that no task was compiled to")
                if not self.whole:
                    refuse_variables(document)
                return NodeSettings(from_document(behaviour, document))
            if not is_known(behaviour):
                name = path.rsplit("/", 1)[-1] if path != "/" else behaviour.name
                return NodeSettings(
                    foreign_node(behaviour, name),
                    remark="kept as it is, as a foreign behaviour; list it under `code:` in grip.yaml",
                )
            return convert_behaviour(behaviour)
        except NoEquivalentError as why:
            self.issues.add("no-equivalent", path, str(why))
            return NodeSettings({"kind": "sequence"})

    def children(self, behaviour: Behaviour, path: str) -> dict[str, dict[str, object]]:
        """Return the children of a behaviour by name."""
        result: dict[str, dict[str, object]] = {}
        names = distinct(child.name for child in behaviour.children)
        for name, child in zip(names, behaviour.children, strict=True):
            below = model.join(path, name)
            if name != child.name:
                self.issues.add("renamed", below, f"was called {child.name!r}")
            result[name] = self.node(child, below)
        return result


def _rules(behaviour: Behaviour, children: Mapping[str, Any], selected: tuple[int, ...]) -> list[dict[str, Any]]:
    """Return the rules of a parallel that succeeds with some of its children: any failure comes before that."""
    when: dict[str, Any] = {}
    for (name, below), child in zip(children.items(), behaviour.children, strict=True):
        labels = [label for label, means in _ends(child, below).items() if means == "success"]
        when[name] = labels[0] if len(labels) == 1 else labels
    chosen = [name for n, name in enumerate(children) if n in selected]
    return [
        {"at_least": 1, "ends": "failure", "then": "failure"},
        {"when": {name: when[name] for name in chosen}, "then": "success"},
    ]


def _ends(behaviour: Behaviour, keys: Mapping[str, Any]) -> Mapping[str, str]:
    """Return each outcome of a node and what it means."""
    if isinstance(behaviour, Node):
        return behaviour.meaning
    return ENDS.get(keys.get("node", ""), _PLAIN)


_OF_A_RUN = {
    *("id", "iterator", "logger", "parent", "children", "status", "feedback_message"),
    *("qualified_name", "blackbox_level", "blackboards"),
}
"""Attributes that every behaviour has and that say nothing of how it was made."""


def foreign_node(behaviour: Behaviour, name: str) -> dict[str, object]:
    """Return the keys of a foreign node of this name that makes a behaviour like this one.

    Each argument of its constructor is looked for in an attribute of the same name. Whether these are right is seen
    by making one: its attributes have to be equal.

    Raises:
        NoEquivalentError: it can't be made again of literals; the text says why.
    """
    cls = type(behaviour)
    where = f"{cls.__module__}:{cls.__qualname__}"
    found: object = sys.modules.get(cls.__module__)
    for part in cls.__qualname__.split("."):  # what other programs find under its name
        found = getattr(found, part, None)
    if cls.__module__ == "__main__" or found is not cls:
        raise NoEquivalentError(f"{cls.__qualname__} can't be imported by a name")
    if behaviour.children:
        raise NoEquivalentError(f"{where} has children, and is no class that a task has")
    args: dict[str, object] = {}
    for parameter in inspect.signature(cls).parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.name != "name":
            value = getattr(behaviour, parameter.name, parameter.empty)
            if not _literal(value):
                raise NoEquivalentError(f"{where}: which {parameter.name!r} it was made with isn't known as a literal")
            if type(value) is not type(parameter.default) or value != parameter.default:
                args[parameter.name] = value
        elif behaviour.name != name:
            args["name"] = behaviour.name
    _compare(behaviour, where, args, "name" in inspect.signature(cls).parameters)
    return {"kind": "foreign", "behaviour": where, **({"args": args} if args else {})}


def _literal(value: object) -> bool:
    if isinstance(value, list):
        return all(map(_literal, value))
    if isinstance(value, dict):
        return all(isinstance(key, str) and _literal(item) for key, item in value.items())
    return value is None or type(value) in (bool, int, float, str)


def _compare(behaviour: Behaviour, where: str, args: dict[str, Any], named: bool) -> None:
    given = {**({"name": behaviour.name} if named else {}), **args}
    try:
        again = type(behaviour)(**given)
    except Exception as error:
        raise NoEquivalentError(f"{where} can't be made again: {type(error).__name__}: {error}") from error
    mine, other = vars(behaviour), vars(again)
    for name in (mine.keys() | other.keys()) - _OF_A_RUN:
        if name not in mine or name not in other or not _equal(mine[name], other[name]):
            raise NoEquivalentError(f"{where}: made again its {name!r} would be another one")


def _equal(one: object, other: object) -> bool:
    try:
        return type(one) is type(other) and bool(one == other)
    except Exception:  # noqa: BLE001 - what can't be compared isn't known to be equal
        return False
