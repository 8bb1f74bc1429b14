"""The manifest of a component's node: each field of the interface is a port, each outcome number a label."""

from __future__ import annotations

from grip_bt.catalog.component_file import ComponentFile
from grip_bt.catalog.interface_spec import INTEGER_TYPES, FieldSpec, InterfaceSpec
from grip_bt.catalog.manifest import InputPort, Manifest, OutputPort
from grip_bt.graph.frozen import FrozenDict
from grip_bt.graph.model import Meaning

from .contract import INPUT, OUTCOME

CODES = ("server_lost", "timed_out", "bad_reply")
_BUILTINS = {"bool": "bool", "string": "str", "wstring": "str", "float32": "float", "float64": "float"}


def class_name(component: ComponentFile) -> str:
    """Return the name of a component's leaf, such as `AntipodalGrasps`."""
    return "".join(part.capitalize() for part in component.name.split("_"))


def face(component: ComponentFile, interface: InterfaceSpec) -> Manifest:
    """Return the manifest of a component's node."""
    outcomes: dict[str, Meaning] = {**component.meanings(), "failure": "failure"}
    inputs = {f.name: _input(component, f) for f in interface.request}
    outputs = {f.name: _output(component, f) for f in interface.response if f.name != OUTCOME}
    return Manifest(
        id=f"component/{component.name}",
        doc=component.doc or interface.doc or f"Calls {component.server}.",
        implementation=f"leaf.py:{class_name(component)}",
        inputs=FrozenDict(inputs),
        outputs=FrozenDict(outputs),
        outcomes=FrozenDict(outcomes),
        codes=CODES,
    )


def port_type(field: FieldSpec) -> str:
    """Return the type of a field as a port that no component file declares."""
    item = "int" if field.type in INTEGER_TYPES else _BUILTINS.get(field.type, field.type)
    return f"list[{item}]" if field.array else item


def _input(component: ComponentFile, field: FieldSpec) -> InputPort:
    return InputPort(
        type=component.port_type(field.name, port_type(field)),
        doc=_doc(component, field),
        required=field.name == INPUT,
    )


def _output(component: ComponentFile, field: FieldSpec) -> OutputPort:
    return OutputPort(type=component.port_type(field.name, port_type(field)), doc=_doc(component, field))


def _doc(component: ComponentFile, field: FieldSpec) -> str:
    return (component.ports[field.name].doc if field.name in component.ports else "") or field.doc
