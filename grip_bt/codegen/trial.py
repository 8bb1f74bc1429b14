"""What a component's rules make of an answer with nothing in it: the case that a generated test can know."""

from __future__ import annotations

from functools import partial
from typing import Any

from grip_bt.base.errors import EvaluationError
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.ros_config import INTEGER_TYPES, FieldSpec, InterfaceSpec

from .contract import output_ports

_DEFAULTS: dict[str, Any] = {"bool": False, "string": "", "wstring": "", "float32": 0.0, "float64": 0.0}


def default_reply(component: ComponentFile, interface: InterfaceSpec) -> dict[str, Any]:
    """Return the outputs of an empty answer, those that are numbers, texts, truth values or lists."""
    received = interface.request if component.kind == "msg" else interface.response
    fields = {f.name: f for f in received}
    ports = output_ports(component, interface)
    return {port: _default(fields[at]) for port, at in ports.items() if at in fields and _known(fields[at])}


def default_outcome(component: ComponentFile, interface: InterfaceSpec) -> tuple[dict[str, Any], str | None] | None:
    """Return an empty answer and the outcome that the rules give it, None for none of them.

    Returns:
        None when the rules read fields whose empty values aren't plain literals.
    """
    reply = default_reply(component, interface)
    for label, text in component.rules.items():
        rule = parse_expression(text)
        if any(name not in reply for name in rule.names):
            return None
        try:
            if condition_of(rule, {name: partial(reply.__getitem__, name) for name in rule.names})():
                return reply, label
        except EvaluationError:
            return None
    return reply, None


def _known(field: FieldSpec) -> bool:
    return field.array or field.type in _DEFAULTS or field.type in INTEGER_TYPES


def _default(field: FieldSpec) -> Any:
    return [] if field.array else _DEFAULTS.get(field.type, 0)
