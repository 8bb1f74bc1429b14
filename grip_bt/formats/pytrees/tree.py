"""Walking a tree of behaviours and writing the task that does the same."""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from py_trees.behaviour import Behaviour

from grip_bt.compilers.to_tree import CompiledTree
from grip_bt.formats.imported import Imported, Issues
from grip_bt.formats.names import distinct, is_literal, node_name
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.foreign import Foreign, by_path, class_path
from grip_bt.nodes.node import Node
from grip_bt.nodes.tree_code import parameters_of
from grip_bt.task import model
from grip_bt.task.validation.parts import DRAWN

from .classes import ENDS, INSIDE, NodeSettings, convert_behaviour, from_document, refuse_variables
from .keys import Keys, NoEquivalentError, keys_of

_PLAIN = {"success": "success", "failure": "failure"}
_COMPOSITES = {name for name, kind in model.KINDS.items() if "children" in kind.model_fields}


def to_task(tree: CompiledTree | Behaviour, name: str = "", built_by: str = "") -> Imported:
    """Return the task of a tree.

    A compiled task gives its own document back, with what was changed on its behaviours since: nodes added, removed
    or moved, settings changed. Any other tree is read behaviour by behaviour: what a kind or a node type does exactly
    becomes one, the rest stays as it is, as foreign nodes.

    Args:
        tree: a compiled task, or the root of any py_trees tree.
        name: the task's name; by default the document's, or the root's.
        built_by: the function, `package.module:name`, that builds the tree and will again for each run; without it,
            behaviours are kept that can be made of literals, and others are refused.

    Raises:
        ImportRefusedError: behaviours have no equivalent; the error names each with its path and the reason.
    """
    if isinstance(tree, CompiledTree):
        reader: Reader = Reader(whole=True)
        keys = reader.node(tree.root, "/")
        reader.issues.raise_if_refused("the tree")
        task = tree.task.model_dump(by_alias=True, exclude_unset=True, exclude={"root"})
        made = model.Task.model_validate({**task, "root": keys, **({"name": name} if name else {})})
        return Imported({made.name: made}, tuple(reader.issues))
    reader = _OtherReader(tree, built_by)
    return imported(reader, tree, name)


def drawn(root: Behaviour, source: str) -> tuple[model.Task, dict[str, Behaviour], Keys]:
    """Return a task that shows a tree as it is, node by node, which behaviour each path is, and the variables of keys.

    Args:
        source: where the tree comes from; it stands in the task, `x-tree`.
    """
    reader = _Drawer(root)
    task = imported(reader, root, "", {DRAWN: source}).task
    return task, reader.places, reader.keys


def imported(reader: Reader, root: Behaviour, name: str, more: Mapping[str, Any] | None = None) -> Imported:
    """Return the task of what a reader reads. Raises ImportRefusedError: behaviours have no equivalent."""
    keys = reader.node(root, "/")
    reader.issues.raise_if_refused("the tree")
    task = {"grip": model.FORMAT_VERSION, "name": name or node_name(root.name) or "tree", **(more or {})}
    meaning = dict(getattr(root, "meaning", _PLAIN))
    task |= {"outcomes": meaning} if meaning != _PLAIN else {}
    task |= {"data": reader.keys.initial()} if reader.keys.names else {}
    made = model.Task.model_validate({**task, "root": keys})
    return Imported({made.name: made}, tuple(reader.issues))


class Reader:
    """Reads behaviours, one by one; `whole`: they are those of a task, which declares all variables."""

    def __init__(self, whole: bool):
        self.whole = whole
        self.issues = Issues()
        self.keys = Keys()

    def node(self, behaviour: Behaviour, path: str) -> dict[str, Any]:
        """Return the keys of a node and of all below it."""
        equal = self.equal(behaviour, path)
        keys = dict(equal.settings)
        if equal.remark:
            self.issues.add("changed", path, equal.remark)
        if keys.get("kind") == "subtask" or keys.keys() & {"node", "children"}:
            return keys  # what is below stands elsewhere, or is there
        if isinstance(behaviour, Foreign):
            if not isinstance(behaviour.document, model.Foreign) or not behaviour.document.children:
                return keys
            behaviour = behaviour.decorated
        children = self.children(behaviour, model.join(path, INSIDE) if equal.inverted else path)
        if equal.failures:
            keys["exits"] = {
                f"{name}.{label}": "failure"
                for (name, below), child in zip(children.items(), behaviour.children, strict=True)
                for label, means in _ends(child, below).items()
                if means == "failure"
            }
        if equal.selected:
            keys["rules"] = _rules(behaviour, children, equal.selected)
        if keys["kind"] == "parallel" and self.keys.names:
            keys["order"] = "declared"  # what one writes the next one reads, in the same tick
        if equal.inverted:
            children = {INSIDE: {"kind": "invert", "child": children}}
        if keys["kind"] == "foreign" and not children:
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
            return self.other(behaviour, path)
        except NoEquivalentError as why:
            self.issues.add("no-equivalent", path, str(why))
            return NodeSettings({"kind": "sequence"})

    def other(self, behaviour: Behaviour, path: str) -> NodeSettings:
        """Return what a behaviour is that comes from no task. Raises NoEquivalentError: nothing."""
        try:
            return convert_behaviour(behaviour, self.keys)
        except NoEquivalentError as why:
            return self.foreign(behaviour, path, why)

    def foreign(self, behaviour: Behaviour, path: str, why: NoEquivalentError) -> NodeSettings:
        """Return the foreign node that holds a behaviour. Raises NoEquivalentError: it can't be made again."""
        if type(behaviour).__module__.startswith("py_trees."):
            raise why
        name = path.rsplit("/", 1)[-1] if path != "/" else behaviour.name
        return NodeSettings(foreign_node(behaviour, name), remark=_LISTED)

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


_LISTED = "kept as it is, as a foreign behaviour; list it under `code:` in grip.yaml"


class _OtherReader(Reader):
    """Reads a tree that comes from no task, and that code builds."""

    def __init__(self, root: Behaviour, built_by: str):
        super().__init__(whole=False)
        self._built_by = built_by
        self._at = {id(behaviour): at for at, behaviour in by_path(root).items()}
        for behaviour in root.iterate():
            try:
                convert_behaviour(behaviour, Keys())
            except NoEquivalentError:
                self.keys.kept.update(*(found.values() for found in keys_of(behaviour)))
        if built_by:
            for behaviour in root.iterate():  # which keys are variables is known when all behaviours were looked at
                with suppress(NoEquivalentError):
                    convert_behaviour(behaviour, self.keys)

    def foreign(self, behaviour: Behaviour, path: str, why: NoEquivalentError) -> NodeSettings:
        reads, writes = keys_of(behaviour)
        bound = {
            word: shared
            for word, found in (("in", reads), ("out", writes))
            if (shared := {key: self.keys.names[key] for key in found if key in self.keys.names})
        }
        try:
            made = super().foreign(behaviour, path, why)
            return replace(made, settings={**made.settings, **bound})
        except NoEquivalentError:
            if not self._built_by:
                raise
        remark = f"kept as it is ({why}), as {self._built_by} builds it: list that under `code:` in grip.yaml"
        where = {"behaviour": class_path(behaviour), "built_by": self._built_by, "at": self._at[id(behaviour)]}
        return NodeSettings({"kind": "foreign", **where, **bound}, remark=remark)


class _Drawer(Reader):
    """Draws a tree as it is: each behaviour is one node, a kind only where that looks the same."""

    def __init__(self, root: Behaviour):
        super().__init__(whole=False)
        self.places: dict[str, Behaviour] = {}

    def equal(self, behaviour: Behaviour, path: str) -> NodeSettings:
        self.places[path] = behaviour
        if behaviour.children and not isinstance(behaviour, Node):
            with suppress(NoEquivalentError):
                equal = convert_behaviour(behaviour)
                if not equal.inverted:
                    return NodeSettings(equal.settings)
        words = {"args": _literals_of(behaviour)}
        words["in"], words["out"] = (
            {local if local == key else f"{local} is {key}": self.keys.variable(key) for local, key in found.items()}
            for found in keys_of(behaviour, remapped=True)
        )
        return NodeSettings(
            {"kind": "foreign", "behaviour": re.sub(r"[^\w.:]", "_", class_path(behaviour))}
            | {k: v for k, v in words.items() if v}
        )


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
    known: Mapping[str, str] | None = getattr(behaviour, "meaning" if isinstance(behaviour, Node) else "ends", None)
    return known or (_PLAIN if "precondition" in keys else ENDS.get(keys.get("node", ""), _PLAIN))


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
        raise NoEquivalentError(f"{where} has children, and isn't a class that a task has")
    args: dict[str, object] = {}
    for parameter in inspect.signature(cls).parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.name != "name":
            value = getattr(behaviour, parameter.name, parameter.empty)
            if not is_literal(value):
                raise NoEquivalentError(f"{where}: which {parameter.name!r} it was made with isn't known as a literal")
            if type(value) is not type(parameter.default) or value != parameter.default:
                args[parameter.name] = value
        elif behaviour.name != name:
            args["name"] = behaviour.name
    _compare(behaviour, where, args, "name" in inspect.signature(cls).parameters)
    return {"kind": "foreign", "behaviour": where, **({"args": args} if args else {})}


def _literals_of(behaviour: Behaviour) -> dict[str, Any]:
    """Return the arguments of a behaviour's constructor that can be read off its attributes."""
    found = {name: getattr(behaviour, name, None) for name in parameters_of(type(behaviour)) if name != "name"}
    return {name: value for name, value in found.items() if value is not None and is_literal(value)}


def _compare(behaviour: Behaviour, where: str, args: dict[str, Any], named: bool) -> None:
    given = {**({"name": behaviour.name} if named else {}), **args}
    try:
        again = type(behaviour)(**given)
    except Exception as error:
        raise NoEquivalentError(f"{where} can't be made again: {type(error).__name__}: {error}") from error
    mine, other = vars(behaviour), vars(again)
    for name in (mine.keys() | other.keys()) - _OF_A_RUN:
        if name not in mine or name not in other or not is_equal(mine[name], other[name], otherwise=False):
            raise NoEquivalentError(f"{where}: made again its {name!r} would be another one")


def is_equal(one: object, other: object, otherwise: bool) -> bool:
    """Tell whether two values are equal and of one class; `otherwise`: where they can't be compared."""
    try:
        return type(one) is type(other) and bool(one == other)
    except Exception:  # noqa: BLE001 - somebody's values may do anything
        return otherwise
