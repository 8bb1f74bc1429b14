"""Node types that a file's TreeNodesModel declares, and leaves; unknown ones get a manifest."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.frozen import FrozenDict
from grip_bt.formats.btcpp.drafts import Board, Keys, key_of, type_named
from grip_bt.formats.imported import Issues
from grip_bt.formats.names import free
from grip_bt.formats.xml_trees import Element, Library, TreeFiles, read_elements
from grip_bt.task.catalog import Catalog, Manifest, parse_type
from grip_bt.task.catalog.manifest import InputPort, OutputPort, Parameter
from grip_bt.task.parts import Meaning

_DIRECTIONS = {"input_port": "in", "output_port": "out", "inout_port": "inout", "bidirectional_port": "inout"}


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
    lenient = True

    def __init__(self, source: str, folder: Path | None, bound: Path | None, library: Library | None = None):
        super().__init__(source, folder, bound, library)
        self.models: dict[str, Model] = {}
        self.issues = Issues(source)

    def wanted(self, root: Element, name: str) -> str:
        """Return the name of a tree that is asked for.

        Raises:
            DocumentError: there is none of that name.
        """
        if self.tree(name, root) is None:
            there = f"{nearest(name, self.trees)} (available: {listing(self.trees)})"
            raise DocumentError(f"there is no tree {name!r}{there}", self.source)
        return name

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
        """Return the ID of a tree, which needs none."""
        return tree.attributes.get("ID") or free("BehaviorTree", self.trees)

    def stray(self, element: Element) -> None:
        """Leave out what BT.CPP doesn't look at."""
        text = "isn't <BehaviorTree>, <TreeNodesModel> or <include>, and was left out"
        self.issues.add("left-out", str(element), text, element.source, element.line)

    def found(self, name: str, path: Path, others: int) -> None:
        """Note where a tree was found that no file includes."""
        text = f"was found in {path}" + (f"; {others} other files have one of that name" if others else "")
        self.issues.add("changed", f"<BehaviorTree> {name!r}", text, self.source)

    def take_model(self, element: Element) -> None:
        """Take in the ports of a node type."""
        name = element.attributes.get("ID", "")
        if not name:
            return
        ports: dict[str, Port] = {}
        for port in element.children:
            direction = _DIRECTIONS.get(port.tag)
            if direction is not None and port.attributes.get("name"):
                said = port.attributes
                ports[said["name"]] = Port(direction, said.get("type", ""), said.get("default"), port.text.strip())
        before = self.models.get(name)
        self.models[name] = Model(element.tag, {**(before.ports if before is not None else {}), **ports})

    def take_models(self, text: str, path: Path) -> None:
        """Take in the models of a file that nobody includes; what can't be read is left alone."""
        try:
            self._take(read_elements(text, str(path), self.lenient), path.parent, ours=False)
        except DocumentError:
            self.issues.add("left-out", path.name, "can't be read, and its models weren't")


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
    """An unknown node type: what the model says of it and how it is used.

    Attributes:
        there: its manifest of an earlier import, to which only what it lacks is added.
        controls: whether it has children.
    """

    name: str
    model: Model | None
    there: Manifest | None = None
    controls: bool = False
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
        if self.there is None:
            for port, said in self.declared.items():
                self.uses.setdefault(port, PortUse(said, True))
        parameters: dict[str, Parameter] = {}
        inputs: dict[str, InputPort] = {}
        outputs: dict[str, OutputPort] = {}
        for port, use in self.uses.items():
            direction, kind, doc = use.port.direction, type_named(use.port.type), use.port.doc
            if not use.bound and direction != "out" and (use.literal or not use.declared):
                always = use.times == self.times and self.there is None
                parameters[port] = _parameter(use.port, kind, always=always)
                continue
            if direction != "out":
                inputs[port] = InputPort(type=kind, doc=doc, required=False)
            if direction != "in":
                outputs[port] = OutputPort(type=kind, doc=doc, on=tuple(_OUTCOMES) if self.controls else ())
        if self.there is not None:
            return self._widened(parameters, inputs, outputs)
        return Manifest(
            id=self.id,
            doc=f"{self.name} of BehaviorTree.CPP; its code has to be written.",
            implementation=f"leaf.py:{class_name(self.name)}",
            parameters=FrozenDict(parameters),
            inputs=FrozenDict(inputs),
            outputs=FrozenDict(outputs),
            **({"outcomes": FrozenDict(_OUTCOMES), "moves": False} if self.controls else {}),
        )

    def _widened(self, parameters: Ports, inputs: Ports, outputs: Ports) -> Manifest:
        """Return the manifest that was there with the ports that it lacks; tasks that it fits still fit."""
        there = self.there
        assert there is not None, "only of one that was there"
        known = {**there.parameters, **there.inputs, **there.outputs}
        bound = {port for port, use in self.uses.items() if use.bound}
        more_inputs = {port: p for port, p in inputs.items() if port not in known or port in there.parameters}
        more_outputs = {port: p for port, p in outputs.items() if port not in known or port in there.parameters}
        new: dict[str, Parameter] = {port: p for port, p in parameters.items() if port not in known}
        for port, said in there.parameters.items():
            use = self.uses.get(port)
            if said.required and (use is None or use.bound or use.times < self.times):
                kind = said.type if parse_type(said.type).optional else f"{said.type} | None"
                new[port] = Parameter(type=kind, doc=said.doc, default=None)
        if not (new or bound & {*more_inputs, *more_outputs}):
            return there
        changed = {
            "parameters": FrozenDict({**there.parameters, **new}),
            "inputs": FrozenDict({**there.inputs, **more_inputs}),
            "outputs": FrozenDict({**there.outputs, **more_outputs}),
        }
        return there.model_copy(update=changed)


Ports = Mapping[str, Any]
_OUTCOMES: dict[str, Meaning] = {"success": "success", "failure": "failure", "skipped": "success"}


def _parameter(port: Port, kind: str, *, always: bool) -> Parameter:
    """Return a parameter; one that isn't always given has the model's default, or is null."""
    kind, doc = kind if kind != "Any" else "str", port.doc
    if port.default is not None and key_of(port.default, "") is None:
        return Parameter(type=kind, doc=doc, default=value_of_text(port.default, kind))
    return Parameter(type=kind, doc=doc) if always else Parameter(type=f"{kind} | None", doc=doc, default=None)


def class_name(name: str) -> str:
    """Return the name of the class that a node type has in Python."""
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

    def leaf(self, name: str, said: dict[str, str], board: Board, controls: bool = False) -> Keys:
        """Return the keys of a leaf of a node type, given port -> what its attribute says.

        Args:
            controls: whether it decides over children.

        Raises:
            ValueError: a port isn't there, or can't hold what it is given.
        """
        ids = (name.replace("__", "/"), f"{GROUP}/{_WRONG.sub('_', name)}", f"nav2/{name}")
        known = next((self.catalog.get(i) for i in ids if i in self.catalog), None)
        if known is not None and (known.implementation.startswith("grip_bt.") or not known.id.startswith(f"{GROUP}/")):
            return self.made(known, said, board)
        face = self.faces.get(name)
        if face is None:
            face = self.faces[name] = UnknownNodeType(name, self.models.get(name), known)
        face.times, face.controls = face.times + 1, face.controls or controls
        if face.model is not None:
            said = {**{p: d.default for p, d in face.model.ports.items() if d.default is not None}, **said}
        for port, text in said.items():
            face.use(port, bound=key_of(text, port) is not None)
        return self.made(self.settled.get(name) or face.manifest(), said, board)

    def made(self, manifest: Manifest, said: dict[str, str], board: Board) -> Keys:
        """Return the keys of a leaf that has a manifest.

        Raises:
            ValueError: a port isn't there, or can't hold what it is given.
        """
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
        if port not in manifest.outputs:
            raise ValueError(_no_port(manifest, port))
        # an output without a key in braces isn't written by BT.CPP either

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
