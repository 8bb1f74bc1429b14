"""Node types that a file's TreeNodesModel declares, and leaves; unknown ones get a manifest."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.base.errors import listing, nearest
from grip_bt.base.frozen import FrozenDict
from grip_bt.formats.btcpp.drafts import Board, Keys, key_of, type_named
from grip_bt.formats.imported import Issues
from grip_bt.formats.xml_trees import Element, TreeFiles
from grip_bt.task.catalog import Catalog, Manifest, parse_type
from grip_bt.task.catalog.manifest import InputPort, OutputPort, Parameter

_DIRECTIONS = {"input_port": "in", "output_port": "out", "inout_port": "inout"}


@dataclass(frozen=True)
class Port:
    """A port as a TreeNodesModel says it; `direction` is `in`, `out` or `inout`."""

    direction: str
    type: str = ""
    default: str | None = None
    doc: str = ""


@dataclass(frozen=True)
class Model:
    """A node type as a TreeNodesModel says it; `kind` is `Action`, `Condition`, `Control`, `Decorator` or `SubTree`."""

    kind: str
    ports: dict[str, Port] = field(default_factory=dict)


class Document(TreeFiles):
    """What a file and its includes say: trees and models by ID, and what to know about the file."""

    include_tags = ("include",)
    path_attributes = ("path",)

    def __init__(self, source: str, folder: Path | None, bound: Path | None):
        super().__init__(source, folder, bound)
        self.models: dict[str, Model] = {}
        self.issues = Issues(source)

    def check_root(self, root: Element) -> None:
        """Refuse a file of another version than 4."""
        said = root.attributes.get("BTCPP_format")
        if root.tag != "root":
            raise root.error('a file of BehaviorTree.CPP begins with <root BTCPP_format="4">')
        if said is not None and said.split(".")[0] != "4":
            raise root.error(f"BTCPP_format is {said}, and 4 is read; BT.CPP's convert_v3_to_v4.py makes one")
        if said is None:
            text = 'has no BTCPP_format="4"; it was read as if it had'
            self.issues.add("changed", str(root), text, root.source, root.line)

    def name_of(self, tree: Element) -> str:
        """Return the ID of a tree; the first one needs none."""
        return tree.attributes.get("ID") or ("" if self.trees else "BehaviorTree")

    def take_model(self, element: Element) -> None:
        """Take in the ports of a node type."""
        name = element.attributes.get("ID", "")
        if not name:
            raise element.error("needs an `ID`")
        ports: dict[str, Port] = {}
        for port in element.children:
            direction = _DIRECTIONS.get(port.tag)
            if direction is not None and port.attributes.get("name"):
                said = port.attributes
                ports[said["name"]] = Port(direction, said.get("type", ""), said.get("default"), port.text.strip())
        self.models[name] = Model(element.tag, ports)


GROUP = "btcpp"
_WRONG = re.compile(r"[^A-Za-z0-9_]")
_TRUTH = {
    **dict.fromkeys(("true", "True", "TRUE", "1"), True),
    **dict.fromkeys(("false", "False", "FALSE", "0"), False),
}


def value_of_text(text: str, type_name: str) -> Any:
    """Return the value that BT.CPP's `convertFromString` makes of a text; JSON for what isn't a scalar.

    Raises:
        ValueError: it isn't one of this type.
    """
    wanted = parse_type(type_name)
    if wanted.optional and text == "null":
        return None
    if wanted.name == "str" or (wanted.name == "Any" and not text.startswith("json:")):
        return text
    if wanted.name == "bool":
        if text.strip() in _TRUTH:
            return _TRUTH[text.strip()]
    elif wanted.name == "int":
        return int(text)
    elif wanted.name == "float":
        number = float(text)
        if math.isfinite(number):
            return number
    else:
        return json.loads(text.removeprefix("json:"))
    raise ValueError(f"{text!r} isn't a {wanted}")


@dataclass
class PortUse:
    """How one port of an unknown node type is used in the whole file; without a model it may be in and out."""

    port: Port
    declared: bool
    literal: bool = False
    bound: bool = False
    times: int = 0


@dataclass
class UnknownNodeType:
    """An unknown node type: what the model says of it and how it is used."""

    name: str
    model: Model | None
    uses: dict[str, PortUse] = field(default_factory=dict)
    times: int = 0

    @property
    def id(self) -> str:
        """Its id in the catalogue."""
        return f"{GROUP}/{_WRONG.sub('_', self.name)}"

    def __post_init__(self) -> None:
        """Begin with the ports of its model."""
        self.declared = self.model.ports if self.model is not None else {}

    def use(self, port: str, *, bound: bool) -> None:
        """Note how a port is used."""
        use = self.uses.setdefault(port, PortUse(self.declared.get(port, Port("inout")), port in self.declared))
        use.bound, use.literal, use.times = use.bound or bound, use.literal or not bound, use.times + 1

    def manifest(self) -> Manifest:
        """Return its manifest: a port that only has literals is a parameter."""
        for port, said in self.declared.items():
            self.uses.setdefault(port, PortUse(said, True))
        parameters: dict[str, Parameter] = {}
        inputs: dict[str, InputPort] = {}
        outputs: dict[str, OutputPort] = {}
        for port, use in self.uses.items():
            direction, kind, doc = use.port.direction, type_named(use.port.type), use.port.doc
            if not use.bound and direction != "out" and (use.literal or not use.declared):
                parameters[port] = _parameter(use.port, kind, always=use.times == self.times)
                continue
            if direction != "out":
                inputs[port] = InputPort(type=kind, doc=doc, required=False)
            if direction != "in":
                outputs[port] = OutputPort(type=kind, doc=doc)
        return Manifest(
            id=self.id,
            doc=f"{self.name} of BehaviorTree.CPP; its code has to be written.",
            implementation=f"leaf.py:{_class(self.name)}",
            parameters=FrozenDict(parameters),
            inputs=FrozenDict(inputs),
            outputs=FrozenDict(outputs),
        )


def _parameter(port: Port, kind: str, *, always: bool) -> Parameter:
    """Return a parameter; one that isn't always given has the model's default, or is null."""
    kind, doc = kind if kind != "Any" else "str", port.doc
    if port.default is not None and key_of(port.default, "") is None:
        return Parameter(type=kind, doc=doc, default=value_of_text(port.default, kind))
    return Parameter(type=kind, doc=doc) if always else Parameter(type=f"{kind} | None", doc=doc, default=None)


def _class(name: str) -> str:
    text = _WRONG.sub("_", name)
    return text if re.match(r"[A-Za-z_]", text) else f"Node{text}"


class Leaves:
    """Makes the leaves of a task: nodes of the catalogue, or those that the file's models declare."""

    def __init__(self, catalog: Catalog, models: dict[str, Model]):
        self.catalog, self.models = catalog, models
        self.faces: dict[str, UnknownNodeType] = {}
        self.settled: dict[str, Manifest] = {}

    def settle(self) -> None:
        """Decide, of what has been seen, which ports of unknown nodes are parameters."""
        self.settled = {name: face.manifest() for name, face in self.faces.items()}

    def leaf(self, name: str, said: dict[str, str], board: Board) -> Keys:
        """Return the keys of a leaf of a node type, given port -> what its attribute says.

        Raises:
            ValueError: a port isn't there, or can't hold what it is given.
        """
        known = next(
            (i for i in (name.replace("__", "/"), f"{GROUP}/{_WRONG.sub('_', name)}") if i in self.catalog), None
        )
        if known is not None:
            return self._known(self.catalog.get(known), said, board)
        face = self.faces.setdefault(name, UnknownNodeType(name, self.models.get(name)))
        face.times += 1
        if face.model is not None:
            for port in said:
                if port not in face.model.ports:
                    there = f"{nearest(port, face.model.ports)} (its model has: {listing(face.model.ports)})"
                    raise ValueError(f"{name} has no port {port!r}{there}")
            said = {**{p: d.default for p, d in face.model.ports.items() if d.default is not None}, **said}
        for port, text in said.items():
            face.use(port, bound=key_of(text, port) is not None)
        return self._known(self.settled.get(name) or face.manifest(), said, board)

    def _known(self, manifest: Manifest, said: dict[str, str], board: Board) -> Keys:
        keys: Keys = {"node": manifest.id}
        for port, text in said.items():
            key = key_of(text, port)
            if key is None:
                self._literal(manifest, port, text, keys, board)
            else:
                self._bound(manifest, port, board.variable(key), keys, board)
        return keys

    def _literal(self, manifest: Manifest, port: str, text: str, keys: Keys, board: Board) -> None:
        if port in manifest.parameters:
            keys.setdefault("with", {})[port] = value_of_text(text, manifest.parameters[port].type)
            return
        if port in manifest.inputs:
            name = board.variables.constant(port, manifest.inputs[port].type, text)
            keys.setdefault("in", {})[port] = name
            return
        if port in manifest.outputs:
            raise ValueError(f"the output {port!r} needs a key in braces, such as {{{text or port}}}")
        raise ValueError(_no_port(manifest, port))

    def _bound(self, manifest: Manifest, port: str, variable: str, keys: Keys, board: Board) -> None:
        entry = board.variables.every[variable]
        if port not in manifest.inputs and port not in manifest.outputs:
            if port in manifest.parameters and entry.constant:
                keys.setdefault("with", {})[port] = value_of_text(entry.initial, manifest.parameters[port].type)
                return
            raise ValueError(_no_port(manifest, port))
        if port in manifest.inputs:
            keys.setdefault("in", {})[port] = variable
            entry.read.append(manifest.inputs[port].type)
        if port in manifest.outputs:
            keys.setdefault("out", {})[port] = variable
            entry.written.append(manifest.outputs[port].type)
        both = port in manifest.inputs and port in manifest.outputs
        entry.known = entry.known and not (both and manifest.inputs[port].type == "Any")


def _no_port(manifest: Manifest, port: str) -> str:
    there = [*manifest.parameters, *manifest.inputs, *manifest.outputs]
    what = "takes only a literal for" if port in manifest.parameters else "has no port"
    return f"{manifest.id} {what} {port!r}{nearest(port, there)} (available: {listing(there)})"
