"""The manifest of a component's node: each field of the interface is a port, each outcome number a label."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.catalog.component_file import FEEDBACK, ComponentFile
from grip_bt.task.catalog.manifest import InputPort, Manifest, OutputPort
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec
from grip_bt.task.model import Meaning

from .contract import INPUT, input_ports, output_ports
from .port_fit import port_type

CODES: dict[str, tuple[str, ...]] = {
    "srv": ("server_lost", "timed_out", "bad_reply"),
    "action": ("server_lost", "timed_out", "bad_reply", "rejected", "aborted", "canceled"),
    "msg": ("timed_out", "bad_reply"),
}
"""Why a node of each kind may fail."""
_VERBS = {
    ("srv", "receive"): "Calls",
    ("action", "receive"): "Sends a goal to",
    ("msg", "receive"): "Waits for a message on",
    ("msg", "publish"): "Publishes a message on",
}


def class_name(component: ComponentFile) -> str:
    """Return the name of a component's leaf, such as `AntipodalGrasps`."""
    return "".join(part[:1].upper() + part[1:] for part in component.name.split("_"))


def face(component: ComponentFile, interface: InterfaceSpec) -> Manifest:
    """Return the manifest of a component's node."""
    outcomes: dict[str, Meaning] = {**component.meanings(), "failure": "failure"}
    fields = {f.name: f for f in interface.request}
    inputs = {port: _input(component, fields, port, at) for port, at in input_ports(component, interface).items()}
    outputs = {port: _output(component, interface, port, at) for port, at in output_ports(component, interface).items()}
    if component.kind == "action":
        outputs[FEEDBACK] = _feedback(component, interface, tuple(outcomes))
    return Manifest(
        id=f"component/{component.name}",
        doc=component.doc or interface.doc or f"{_VERBS[component.kind, component.use]} {component.server}.",
        implementation=f"leaf.py:{class_name(component)}",
        inputs=FrozenDict(inputs),
        outputs=FrozenDict(outputs),
        outcomes=FrozenDict(outcomes),
        codes=CODES[component.kind],
        moves=None if component.moves else False,
    )


def _input(component: ComponentFile, fields: Mapping[str, FieldSpec], port: str, at: str) -> InputPort:
    return InputPort(
        type=_type(component, fields, port, at),
        doc=_doc(component, fields, port, at),
        required=port == INPUT and not component.rules,
    )


def _output(component: ComponentFile, interface: InterfaceSpec, port: str, at: str) -> OutputPort:
    fields = {f.name: f for f in (interface.request if component.kind == "msg" else interface.response)}
    return OutputPort(type=_type(component, fields, port, at), doc=_doc(component, fields, port, at))


def _feedback(component: ComponentFile, interface: InterfaceSpec, outcomes: tuple[str, ...]) -> OutputPort:
    """Return the port of the last feedback; it is written however the goal ends, None where there was no feedback."""
    type_ = component.port_type(FEEDBACK, f"{interface.type_name}_Feedback")
    said = component.ports[FEEDBACK].doc if FEEDBACK in component.ports else ""
    optional = type_ if "| None" in type_ or type_ == "Any" else f"{type_} | None"
    return OutputPort(type=optional, doc=said or "the last feedback", on=outcomes)


def _type(component: ComponentFile, fields: Mapping[str, FieldSpec], port: str, at: str) -> str:
    return component.port_type(port, port_type(fields[at]) if at in fields else "Any")


def _doc(component: ComponentFile, fields: Mapping[str, FieldSpec], port: str, at: str) -> str:
    said = component.ports[port].doc if port in component.ports else ""
    return said or (fields[at].doc if at in fields else "")
