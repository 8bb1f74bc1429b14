"""The component contract, checked field by field: request with `input`, response with `outcome`, `returned_object`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from grip_bt.catalog.component_file import ComponentFile
from grip_bt.catalog.interface_spec import FieldSpec, InterfaceSpec
from grip_bt.catalog.types import parse_type
from grip_bt.errors import ContractError, listing, nearest

INPUT, OUTCOME, RETURNED = "input", "outcome", "returned_object"


def check_contract(component: ComponentFile, interface: InterfaceSpec) -> None:
    """Check that an interface keeps the contract and that a component file fits it.

    Raises:
        ContractError: with everything that is wrong: which field, what was found, what is needed.
    """
    problems = list(_problems(component, interface))
    if problems:
        raise ContractError(f"component {component.name}: {interface.source or interface.type_name}", problems)


def _problems(component: ComponentFile, interface: InterfaceSpec) -> Iterator[str]:
    if component.interface != interface.type_name:
        yield f"interface: the component file says {component.interface}, this is {interface.type_name}"
    sides = {"request": interface.request, "response": interface.response}
    for side, name in (("request", INPUT), ("response", OUTCOME), ("response", RETURNED)):
        if _named(sides[side], name) is None:
            yield _missing(side, name, sides[side])
    outcome = _named(interface.response, OUTCOME)
    if outcome is not None and not outcome.is_integer:
        yield f"response: the field {OUTCOME!r} is {outcome.spelling}; it must be one integer, such as int32"
    known = {f.name for fields in sides.values() for f in fields} - {OUTCOME}
    for name, port in component.ports.items():
        if name not in known:
            fields = listing(sorted(known))
            yield f"ports: {name!r} is no field of the interface{nearest(name, known)} (there are: {fields})"
        try:
            parse_type(port.type)
        except ValueError as error:
            yield f"ports: {name}: {error}"
    if component.meanings().get("failure") == "success":
        yield "meaning: the outcome 'failure' can't mean success; calls that fail end with it"


def _named(fields: Sequence[FieldSpec], name: str) -> FieldSpec | None:
    return next((f for f in fields if f.name == name), None)


def _missing(side: str, name: str, fields: Sequence[FieldSpec]) -> str:
    found = listing((f"{f.spelling} {f.name}" for f in fields), nothing="no field at all")
    return f"{side}: the field {name!r} is missing{nearest(name, (f.name for f in fields))} (found: {found})"
