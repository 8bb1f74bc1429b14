"""py_trees' XML -> task. Sub-trees are put in where they are used; what has no equivalent is refused with its line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Success
from py_trees.common import ParallelPolicy

from grip_bt.base.errors import listing, nearest
from grip_bt.formats.imported import Imported, Issues
from grip_bt.formats.names import distinct, node_name
from grip_bt.formats.xml_trees import DEEPEST, MOST_NODES, Element, TreeFiles
from grip_bt.task import model
from grip_bt.task.catalog import Catalog, Manifest

from .classes import convert_behaviour
from .keys import NoEquivalentError
from .xml_values import Constant, Names, Variables, from_text

_POLICIES: dict[str, Callable[[], ParallelPolicy.Base]] = {
    "success_on_all": ParallelPolicy.SuccessOnAll,
    "success_on_one": ParallelPolicy.SuccessOnOne,
}
_DECORATORS: dict[str, tuple[type[Behaviour], dict[str, str]]] = {
    "retry": (decorators.Retry, {"num_failures": "int"}),
    "repeat": (decorators.Repeat, {"num_success": "int"}),
    "timeout": (decorators.Timeout, {"duration": "float"}),
    "inverter": (decorators.Inverter, {}),
    "failureissuccess": (decorators.FailureIsSuccess, {}),
    "successisfailure": (decorators.SuccessIsFailure, {}),
    **{cls.__name__.lower(): (cls, {}) for cls in (decorators.PassThrough, decorators.Count)},
    **{cls.__name__.lower(): (cls, {}) for cls in (decorators.SuccessIsRunning, decorators.FailureIsRunning)},
    "runningisfailure": (decorators.RunningIsFailure, {}),
}
"""Tag -> class, and the types of its attributes."""
_OTHERS = {n.lower(): c for n, c in vars(decorators).items() if isinstance(c, type) and issubclass(c, Behaviour)}


def from_xml(text: str, catalog: Catalog, source: str = "", folder: Path | None = None) -> Imported:
    """Return the task of a file of py_trees' XML.

    A leaf's tag is a catalogue id with a dot for the slash (`<arm.lift>`), or the name of the class that one node of
    the catalogue is implemented by. Each blackboard key becomes a variable of the task; its type is that of the port
    which writes it, or else of one that reads it.

    Args:
        text: the file.
        catalog: where the leaves' manifests are.
        source: what to call the file in messages.
        folder: where included files are looked for, and no further up; without it they are refused.

    Raises:
        DocumentError: it can't be read, or holds something that has no equivalent in a task.
    """
    files = TreeFiles(source, folder)
    main = files.trees[files.load(text)]
    reader = _Reader(catalog, files)
    names = Names()
    names.given = {k: names.meaning(v) for k, v in main.attributes.items() if k not in ("ID", "name")}
    root = main.only_child()
    keys = reader.node(root, names, "/", (main.attributes["ID"],))
    data = reader.variables.declared()
    task = {"grip": model.FORMAT_VERSION, "name": node_name(main.attributes["ID"]), "root": keys}
    task |= {"data": data} if data else {}
    made = model.Task.model_validate(task)
    return Imported({made.name: made}, tuple(reader.issues))


class _Reader:
    def __init__(self, catalog: Catalog, files: TreeFiles):
        self.catalog, self.trees = catalog, files.trees
        self.nodes = 0
        self.variables = Variables()
        self.issues = Issues(files.source)

    def node(self, element: Element, names: Names, path: str, inside: tuple[str, ...]) -> dict[str, Any]:
        """Return the keys of a node and of all below it."""
        while element.tag.lower() in ("subtree", "subtreeplus"):
            element, names, inside = self.sub_tree(element, names, inside)
        self.nodes += 1
        if self.nodes > MOST_NODES or path.count("/") >= DEEPEST:
            raise element.error(f"more than {MOST_NODES} nodes, or {DEEPEST} levels, with all sub-trees")
        tag = element.tag.lower()
        if tag not in ("sequence", "selector", "fallback", "parallel") and tag not in _OTHERS:
            return self.leaf(element, names, path)
        try:
            equal = convert_behaviour(self.behaviour(element, names))
        except NoEquivalentError as why:
            raise element.error(str(why)) from None
        if equal.remark:
            self.issues.add("changed", path, equal.remark)
        children, keys = self.children(element, names, path, inside), dict(equal.settings)
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
        self, element: Element, names: Names, inside: tuple[str, ...]
    ) -> tuple[Element, Names, tuple[str, ...]]:
        """Return the root of a sub-tree, what keys mean in it, and the trees around it."""
        name = element.attributes.get("ID", "")
        if name not in self.trees:
            raise element.error(f"there is no tree {name!r}{nearest(name, self.trees)}")
        if name in inside:
            raise element.error(f"the tree {name!r} holds itself")
        tree = self.trees[name]
        given = {**tree.attributes, **element.attributes}
        own = Names((*names.space, element.attributes.get("name", name)))
        own.given = {k: self.meaning(element, names, v) for k, v in given.items() if k not in ("ID", "name")}
        return tree.only_child(), own, (*inside, name)

    def meaning(self, element: Element, names: Names, text: str) -> str | Constant:
        try:
            return names.meaning(text)
        except ValueError as error:
            raise element.error(str(error)) from None

    def children(self, element: Element, names: Names, path: str, inside: tuple[str, ...]) -> dict[str, dict[str, Any]]:
        result = {}
        wanted = [child.attributes.get("name", child.tag) for child in element.children]
        for name, given, child in zip(distinct(wanted), wanted, element.children, strict=True):
            below = model.join(path, name)
            if name != given:
                self.issues.add("renamed", below, f"was called {given!r}")
            result[name] = self.node(child, names, below, inside)
        return result

    def behaviour(self, element: Element, names: Names) -> Behaviour:
        """Return what py_trees makes of a composite or decorator, without its children."""
        tag = element.tag.lower()
        if tag in _OTHERS:
            if tag not in _DECORATORS:
                raise NoEquivalentError(f"{_OTHERS[tag].__name__}: a task read from XML has none")
            cls, types = _DECORATORS[tag]
            given = self.settings(element, names, types)
            element.only_child()
            try:
                return cls(name="", child=Success(""), **given)
            except TypeError:
                raise element.error(f"needs {listing(types)}") from None
        if tag == "parallel":
            policy = self.settings(element, names, {"policy": "str"}).get("policy", "success_on_one")
            if policy not in _POLICIES:
                raise NoEquivalentError(
                    f"the policy {policy!r}{nearest(policy, _POLICIES)} (available: {listing(_POLICIES)})"
                )
            return composites.Parallel("", _POLICIES[policy]())
        memory = self.settings(element, names, {"memory": "bool"}).get("memory", True)
        return (composites.Sequence if tag == "sequence" else composites.Selector)("", memory)

    def settings(self, element: Element, names: Names, types: dict[str, str]) -> dict[str, Any]:
        """Return the attributes of a composite or decorator; py_trees ignores unknown ones, here they are errors."""
        found = {}
        for name, text in element.attributes.items():
            if name == "name":
                continue
            if name not in types:
                there = listing([*types, "name"])
                raise element.error(f"no attribute {name!r}{nearest(name, types)} (available: {there})")
            meaning = self.meaning(element, names, text)
            if not isinstance(meaning, Constant):
                raise element.error(f"{name}={text!r} is a variable; it has to be a constant here")
            found[name] = _value(element, name, meaning.text, types[name])
        return found

    def leaf(self, element: Element, names: Names, path: str) -> dict[str, Any]:
        manifest = self.manifest(element)
        if element.children:
            raise element.error(f"{manifest.id} is a leaf and can't hold other nodes")
        keys: dict[str, dict[str, Any]] = {"with": {}, "in": {}, "out": {}}
        for name, text in element.attributes.items():
            if name == "name":
                continue
            meaning = self.meaning(element, names, text)
            self.attribute(element, manifest, name, meaning, path, keys)
        return {"node": manifest.id, **{key: said for key, said in keys.items() if said}}

    def attribute(
        self,
        element: Element,
        manifest: Manifest,
        name: str,
        meaning: str | Constant,
        path: str,
        keys: dict[str, dict[str, Any]],
    ) -> None:
        """Put one attribute of a leaf where it belongs: to a parameter, an input or an output."""
        constant = isinstance(meaning, Constant)
        if isinstance(meaning, Constant) and name in manifest.parameters:
            keys["with"][name] = _value(element, name, meaning.text, manifest.parameters[name].type)
        elif isinstance(meaning, Constant) and name in manifest.inputs:
            type_name = manifest.inputs[name].type
            where = "_".join((*path.strip("/").split("/"), name)).strip("_")
            value = _value(element, name, meaning.text, type_name)
            keys["in"][name] = self.variables.constant(node_name(where), type_name, value)
        elif isinstance(meaning, str) and name in manifest.inputs:
            keys["in"][name] = meaning
            self.variables.use(meaning, manifest.inputs[name].type, written=False)
        elif isinstance(meaning, str) and name in manifest.outputs:
            keys["out"][name] = meaning
            self.variables.use(meaning, manifest.outputs[name].type, written=True)
        else:
            there = [*manifest.parameters, *manifest.inputs, *manifest.outputs]
            what = f"{name!r} that is {'a constant' if constant else 'a variable'}"
            raise element.error(f"{manifest.id} takes no {what}{nearest(name, there)} (it has: {listing(there)})")

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


def _value(element: Element, name: str, text: str, type_name: str) -> Any:
    try:
        return from_text(text, type_name)
    except ValueError as error:
        raise element.error(f"{name}: {error}") from None
