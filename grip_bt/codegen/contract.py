"""The component contract, checked field by field: request with `input`, response with `outcome`, `returned_object`.

An interface that somebody else defined needs no such fields when the component file gives its outcomes by rule; its
rules, ports and fixed fields are checked instead. Of an action, request and response are its goal and its result.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from grip_bt.base.errors import ContractError, listing, nearest
from grip_bt.base.expression import parse_expression
from grip_bt.base.types import parse_type
from grip_bt.task.catalog.component_file import FEEDBACK, ComponentFile
from grip_bt.task.catalog.interface_spec import FieldSpec, InterfaceSpec
from grip_bt.task.validation.expression_types import type_of

from .port_fit import FieldsOf, misfits, port_type

INPUT, OUTCOME, RETURNED = "input", "outcome", "returned_object"


def check_contract(
    component: ComponentFile, interface: InterfaceSpec, fields_of: FieldsOf = lambda message: None
) -> None:
    """Check that an interface keeps the contract and that a component file fits it.

    Args:
        component: what is declared.
        interface: what it speaks.
        fields_of: the fields of a message, for ports that are deep in one.

    Raises:
        ContractError: with everything that is wrong: which field, what was found, what is needed.
    """
    problems = list(_problems(component, interface, fields_of))
    if problems:
        raise ContractError(f"component {component.name}: {interface.source or interface.type_name}", problems)


def _problems(component: ComponentFile, interface: InterfaceSpec, fields_of: FieldsOf) -> Iterator[str]:
    if component.interface != interface.type_name:
        yield f"interface: the component file says {component.interface}, this is {interface.type_name}"
    if component.rules:
        yield from _rule_problems(component, interface)
    else:
        yield from _contract_problems(interface)
    yield from _port_problems(component, interface)
    sending = component.kind != "msg" or component.use == "publish"
    yield from misfits(component, interface.request, sending, fields_of)
    yield from misfits(component, interface.response, False, fields_of)
    if component.meanings().get("failure") == "success":
        yield "meaning: the outcome 'failure' can't mean success; calls that fail end with it"


def _contract_problems(interface: InterfaceSpec) -> Iterator[str]:
    sides = {"request": interface.request, "response": interface.response}
    words = {"request": "goal", "response": "result"} if interface.kind == "action" else {}
    missing = False
    for side, name in (("request", INPUT), ("response", OUTCOME), ("response", RETURNED)):
        if _named(sides[side], name) is None:
            missing = True
            yield _missing(words.get(side, side), name, sides[side])
    outcome = _named(interface.response, OUTCOME)
    if outcome is not None and not outcome.is_integer:
        side = words.get("response", "response")
        yield f"{side}: the field {OUTCOME!r} is {outcome.spelling}; it must be one integer, such as int32"
    if missing and interface.response:
        rules = ", ".join(f'{label}: "{rule}"' for label, rule in _suggested_rules(interface).items())
        yield f"(for an interface as it is, give outcomes by rule, such as `outcomes: {{{rules}}}`)"


def _rule_problems(component: ComponentFile, interface: InterfaceSpec) -> Iterator[str]:
    ports = output_ports(component, interface)
    for label, rule in component.rules.items():
        unknown = [name for name in parse_expression(rule).names if name not in ports]
        for name in unknown:
            there_are = listing(sorted(ports))
            yield f"outcomes: the rule of {label!r} reads {name!r}{nearest(name, ports)} (outputs: {there_are})"
        if not unknown:
            yield from _untrue(component, interface, ports, label, rule)


def _untrue(
    component: ComponentFile, interface: InterfaceSpec, ports: Mapping[str, str], label: str, rule: str
) -> Iterator[str]:
    """Yield why a rule can be neither true nor false, as far as the types of the outputs tell."""
    fields = {f.name: f for f in (interface.request if component.kind == "msg" else interface.response)}
    wrong: list[str] = []
    types = {}
    for port, at in ports.items():
        try:
            types[port] = parse_type(component.port_type(port, port_type(fields[at]) if at in fields else "Any"))
        except ValueError:
            return  # told of the port itself
    given = type_of(parse_expression(rule), types, lambda part, reason: wrong.append(reason))
    said = f"outcomes: the rule of {label!r}, `{rule}`"
    yield from (f"{said}: {reason}" for reason in wrong)
    if not wrong and given.name not in ("bool", "Any"):
        example = f"`len({rule}) > 0`" if given.name in ("list", "str", "dict") else f"`{rule} > 0`"
        yield f"{said}, gives a {given}; a rule is true or false: compare it with something, such as {example}"


def _port_problems(component: ComponentFile, interface: InterfaceSpec) -> Iterator[str]:
    known = {f.name for f in (*interface.request, *interface.response)}
    known |= {FEEDBACK} if interface.kind == "action" else set()
    known -= set() if component.rules else {OUTCOME}
    for name, port in component.ports.items():
        field = port.field.split(".")[0] if port.field else name
        if field not in known:
            fields = listing(sorted(known))
            yield f"ports: {field!r} is no field of the interface{nearest(field, known)} (there are: {fields})"
        try:
            parse_type(port.type)
        except ValueError as error:
            yield f"ports: {name}: {error}"
    requests = {f.name for f in interface.request}
    for name in component.fixed:
        if name not in requests:
            there_are = listing(sorted(requests))
            yield f"fixed: {name!r} is no field of the request{nearest(name, requests)} (there are: {there_are})"


def output_ports(component: ComponentFile, interface: InterfaceSpec) -> dict[str, str]:
    """Return the output ports, and where each is in the response; a contract's `outcome` is none."""
    received = interface.request if component.kind == "msg" else interface.response
    if component.kind == "msg" and component.use == "publish":
        return {}
    return component.port_fields(f.name for f in received if component.rules or f.name != OUTCOME)


def input_ports(component: ComponentFile, interface: InterfaceSpec) -> dict[str, str]:
    """Return the input ports, and where each is in the request."""
    if component.kind == "msg" and component.use == "receive":
        return {}
    return component.port_fields(f.name for f in interface.request)


def keeps_contract(interface: InterfaceSpec) -> bool:
    """Tell whether the three fields are there."""
    response = {f.name: f for f in interface.response}
    has_input = any(f.name == INPUT for f in interface.request)
    return has_input and RETURNED in response and OUTCOME in response and response[OUTCOME].is_integer


def suggested_outcomes(interface: InterfaceSpec) -> str:
    """Return outcomes that would be possible, as `--outcomes` takes them."""
    if keeps_contract(interface):
        return "done,failed"
    return "; ".join(f"{label}: {rule}" for label, rule in _suggested_rules(interface).items())


def _suggested_rules(interface: InterfaceSpec) -> dict[str, str]:
    flag = next((f for f in interface.response if f.type == "bool" and not f.array), None)
    if flag is not None:
        return {"done": flag.name, "failed": f"not {flag.name}"}
    several = next((f for f in interface.response if f.array), None)
    return {"found": f"len({several.name}) > 0", "none": "true"} if several is not None else {"done": "true"}


def _named(fields: Sequence[FieldSpec], name: str) -> FieldSpec | None:
    return next((f for f in fields if f.name == name), None)


def _missing(side: str, name: str, fields: Sequence[FieldSpec]) -> str:
    found = listing((f"{f.spelling} {f.name}" for f in fields), nothing="no field at all")
    return f"{side}: the field {name!r} is missing{nearest(name, (f.name for f in fields))} (found: {found})"
