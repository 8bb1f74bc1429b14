"""What rules ask of a manifest again and again, worked out once for all leaves of its kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.task import Leaf
from grip_bt.task.catalog import Catalog, InputPort, Manifest, OutputPort, Type, check_value, parse_type

_EXACT: Mapping[str, tuple[type, ...]] = {"bool": (bool,), "int": (int,), "float": (float, int), "str": (str,)}
"""Type -> the classes whose values are of it, without a further look."""


class Known:
    """A manifest, in the form in which leaves are held against it.

    Attributes:
        manifest: the manifest.
        labels: its outcomes.
        ends: what they are to a container without exits: (meaning, no exit).
        required: parameters that a task must give.
        bound: inputs that a task must bind.
        inputs: input -> its type.
        outputs: output -> its type.
    """

    __slots__ = ("_exact", "_types", "bound", "ends", "inputs", "labels", "manifest", "outputs", "required")

    def __init__(self, manifest: Manifest):
        self.manifest = manifest
        self.labels = frozenset(manifest.outcomes)
        self.ends = tuple((meaning, False) for meaning in dict.fromkeys(manifest.outcomes.values()))
        self.required = frozenset(name for name, p in manifest.parameters.items() if p.required)
        self.bound = frozenset(name for name, p in manifest.inputs.items() if p.required)
        self.inputs, self.outputs = _types_of(manifest.inputs), _types_of(manifest.outputs)
        self._types = {name: p.type for name, p in manifest.parameters.items()}
        self._exact = {name: _EXACT.get(p.type, ()) for name, p in manifest.parameters.items()}

    def fits(self, node: Leaf) -> bool:
        """Tell whether everything that a leaf says is in its manifest, and everything that this needs is said."""
        given, bound = node.with_, node.in_
        exact, inputs, outputs = self._exact, self.inputs, self.outputs
        for name, value in given.items():
            if name not in exact:
                return False
            if type(value) not in exact[name] and check_value(self._types[name], value):
                return False
        for port in bound:
            if port not in inputs:
                return False
        for port in node.out:
            if port not in outputs:
                return False
        if node.meaning and not self.labels.issuperset(node.meaning):
            return False
        return self.required.issubset(given) and self.bound.issubset(bound)


def _types_of(ports: Mapping[str, InputPort] | Mapping[str, OutputPort]) -> dict[str, Type | None]:
    return {name: _type_of(port.type) for name, port in ports.items()}


def _type_of(text: str) -> Type | None:
    try:
        return parse_type(text)
    except ValueError:
        return None


class KnownManifests(dict[str, Known | None]):
    """The nodes of a catalogue, by id; None for one that isn't there."""

    def __init__(self, catalog: Catalog):
        super().__init__()
        self._catalog = catalog

    def __missing__(self, id: str) -> Any:
        known = self[id] = Known(self._catalog.get(id)) if id in self._catalog else None
        return known
