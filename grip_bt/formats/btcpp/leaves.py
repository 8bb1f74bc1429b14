"""Node types that a file's TreeNodesModel declares, and leaves; unknown ones get a manifest."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.base.errors import listing, nearest
from grip_bt.base.frozen import FrozenDict
from grip_bt.formats.blackboard import Board, key_of, value_of_text
from grip_bt.formats.xml_trees import Model, Port
from grip_bt.task.catalog import Catalog, Manifest, parse_type
from grip_bt.task.catalog.manifest import InputPort, OutputPort, Parameter
from grip_bt.task.parts import Meaning

from .drafts import Keys, type_named

GROUP = "btcpp"
_WRONG = re.compile(r"[^A-Za-z0-9_]")


@dataclass
class _PortUse:
    """How one port of an unknown node type is used in the whole file; without a model it may be in and out."""

    port: Port
    declared: bool
    literal: bool = False
    bound: bool = False
    times: int = 0


@dataclass
class _Unknown:
    """An unknown node type: what its model says, its manifest of an earlier import, which only grows, and its use."""

    name: str
    model: Model | None
    there: Manifest | None = None
    controls: bool = False
    uses: dict[str, _PortUse] = field(default_factory=dict)
    times: int = 0

    @property
    def id(self) -> str:
        return f"{GROUP}/{_WRONG.sub('_', self.name)}"

    @property
    def declared(self) -> dict[str, Port]:
        return self.model.ports if self.model is not None else {}

    def use(self, port: str, *, bound: bool) -> None:
        use = self.uses.setdefault(port, _PortUse(self.declared.get(port, Port("inout")), port in self.declared))
        use.bound, use.literal, use.times = use.bound or bound, use.literal or not bound, use.times + 1

    def manifest(self) -> Manifest:
        """Return its manifest: a port that only has literals is a parameter."""
        if self.there is None:
            for port, said in self.declared.items():
                self.uses.setdefault(port, _PortUse(said, True))
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
            return self._widened(self.there, parameters, inputs, outputs)
        return Manifest(
            id=self.id,
            doc=f"{self.name} of BehaviorTree.CPP; its code has to be written.",
            implementation=f"leaf.py:{class_name(self.name)}",
            parameters=FrozenDict(parameters),
            inputs=FrozenDict(inputs),
            outputs=FrozenDict(outputs),
            **({"outcomes": FrozenDict(_OUTCOMES), "moves": False} if self.controls else {}),
        )

    def _widened(self, there: Manifest, parameters: Ports, inputs: Ports, outputs: Ports) -> Manifest:
        """Return the manifest that was there with the ports that it lacks; tasks that it fits still fit."""
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
        self.faces: dict[str, _Unknown] = {}
        self.settled: dict[str, Manifest] = {}

    def settle(self) -> None:
        """Decide, of what has been seen, which ports of unknown nodes are parameters."""
        self.settled = {name: face.manifest() for name, face in self.faces.items()}

    def leaf(self, name: str, said: dict[str, str], board: Board, controls: bool = False) -> Keys:
        """Return the keys of a leaf of a node type, or of one that decides over children; see `leaf_keys`."""
        ids = (name.replace("__", "/"), f"{GROUP}/{_WRONG.sub('_', name)}", f"nav2/{name}")
        known = next((self.catalog.get(i) for i in ids if i in self.catalog), None)
        if known is not None and (known.implementation.startswith("grip_bt.") or not known.id.startswith(f"{GROUP}/")):
            return leaf_keys(known, said, board)
        face = self.faces.get(name)
        if face is None:
            face = self.faces[name] = _Unknown(name, self.models.get(name), known)
        face.times, face.controls = face.times + 1, face.controls or controls
        if face.model is not None:
            said = {**{p: d.default for p, d in face.model.ports.items() if d.default is not None}, **said}
        for port, text in said.items():
            face.use(port, bound=key_of(text, port) is not None)
        return leaf_keys(self.settled.get(name) or face.manifest(), said, board)


def leaf_keys(manifest: Manifest, said: Mapping[str, str], board: Board) -> Keys:
    """Return the keys of a leaf, port -> text given. Raises ValueError: a port isn't there, or can't hold its text."""
    keys: Keys = {"node": manifest.id}
    for port, text in said.items():
        key = key_of(text, port)
        entry = None if key is None else board.entry(key)
        literal = text if entry is None else entry.initial if entry.constant else None
        if key is not None and entry is not None and (port in manifest.inputs or port in manifest.outputs):
            if port in manifest.inputs:
                keys.setdefault("in", {})[port] = board.variable(key)
                entry.read.append(manifest.inputs[port].type)
            if port in manifest.outputs:
                keys.setdefault("out", {})[port] = board.variable(key)
                entry.written.append(manifest.outputs[port].type)
            both = port in manifest.inputs and port in manifest.outputs
            entry.known = entry.known and not (both and manifest.inputs[port].type == "Any")
        elif port in manifest.parameters and literal is not None:
            keys.setdefault("with", {})[port] = value_of_text(literal, manifest.parameters[port].type)
        elif port in manifest.inputs:
            name = board.variables.constant(port, manifest.inputs[port].type, text)
            keys.setdefault("in", {})[port] = name
        elif key is not None or port not in manifest.outputs:  # an output without a key isn't written by BT.CPP either
            raise ValueError(_no_port(manifest, port))
    return keys


def _no_port(manifest: Manifest, port: str) -> str:
    there = [*manifest.parameters, *manifest.inputs, *manifest.outputs]
    what = "takes only a literal for" if port in manifest.parameters else "has no port"
    return f"{manifest.id} {what} {port!r}{nearest(port, there)} (available: {listing(there)})"
