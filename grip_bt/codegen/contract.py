"""The component contract, checked field by field: request with `input`, response with `outcome`, `returned_object`.

An interface that somebody else defined needs no such fields when the component file gives its outcomes by rule; its
rules, ports and fixed fields are checked instead. Of an action, request and response are its goal and its result.

Ports are checked against their fields (types, units, rotations, frames), and only what can never fit is a problem: a
message of somebody's own may have the fields that a value needs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from grip_bt.base.errors import ContractError, listing, nearest
from grip_bt.base.expression import parse_expression
from grip_bt.base.types import BUILTINS, VALUES, Type, parse_type
from grip_bt.task.catalog.component_file import FEEDBACK, ComponentFile
from grip_bt.task.catalog.port_type import LENGTHS, GraspFields, PortType
from grip_bt.task.catalog.ros_config import INTEGER_TYPES, FieldSpec, InterfaceSpec
from grip_bt.task.validation.expressions import type_of

INPUT, OUTCOME, RETURNED = "input", "outcome", "returned_object"


def check_contract(
    component: ComponentFile, interface: InterfaceSpec, fields_of: FieldsOf = lambda message: None
) -> None:
    """Check that an interface keeps the contract, and that a component file fits it.

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
    yield from _port_problems(component, interface, fields_of)
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
    fields = received(component, interface)
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


def _port_problems(component: ComponentFile, interface: InterfaceSpec, fields_of: FieldsOf) -> Iterator[str]:
    known = {f.name for f in (*interface.request, *interface.response)}
    known |= {FEEDBACK} if interface.kind == "action" else set()
    known -= set() if component.rules else {OUTCOME}
    sending = component.kind != "msg" or component.use == "publish"
    for name, port in component.ports.items():
        path = port.field or name
        first = path.split(".")[0]
        if first not in known:
            fields = listing(sorted(known))
            yield f"ports: {first!r} isn't a field of the interface{nearest(first, known)} (available: {fields})"
        try:
            wanted = parse_type(port.type)
        except ValueError as error:
            yield f"ports: {name}: {error}"
            continue
        for side, sent in ((interface.request, sending), (interface.response, False)):
            field = _field_at(side, path, fields_of)
            if isinstance(field, str):
                yield f"ports: {name}: {field}"
            elif field is not None:
                yield from (f"ports: {name}: {fault}" for fault in _faults(port, wanted, field, sent, fields_of))
                if port.grasp is not None:
                    faults = _grasp_faults(port.grasp, component, field, fields_of)
                    yield from (f"ports: {name}/grasp: {fault}" for fault in faults)
    requests = {f.name for f in interface.request}
    for name in component.fixed:
        if name not in requests:
            there_are = listing(sorted(requests))
            yield f"fixed: {name!r} isn't a field of the request{nearest(name, requests)} (available: {there_are})"


def received(component: ComponentFile, interface: InterfaceSpec) -> dict[str, FieldSpec]:
    """Return the fields of what a component answers, by name."""
    return {f.name: f for f in (interface.request if component.kind == "msg" else interface.response)}


def output_ports(component: ComponentFile, interface: InterfaceSpec) -> dict[str, str]:
    """Return the output ports, and where each is in the response; a contract's `outcome` is none."""
    if component.kind == "msg" and component.use == "publish":
        return {}
    fields = received(component, interface)
    return component.port_fields(name for name in fields if component.rules or name != OUTCOME)


def input_ports(component: ComponentFile, interface: InterfaceSpec) -> dict[str, str]:
    """Return the input ports, and where each is in the request."""
    if component.kind == "msg" and component.use == "receive":
        return {}
    return component.port_fields(f.name for f in interface.request)


def keeps_contract(interface: InterfaceSpec) -> bool:
    """Tell whether the three fields are there."""
    return not any(_contract_problems(interface))


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


FieldsOf = Callable[[str], Sequence[FieldSpec] | None]
"""Name of a message -> its fields; None where nobody knows it."""
VALUE_OF = {
    "geometry_msgs/msg/PoseStamped": "Pose",
    "geometry_msgs/msg/Pose": "Pose",
    "geometry_msgs/msg/TransformStamped": "Pose",
    "geometry_msgs/msg/Transform": "Pose",
    "sensor_msgs/msg/PointCloud2": "PointCloud",
    "sensor_msgs/msg/Image": "Image",
    "sensor_msgs/msg/CameraInfo": "CameraInfo",
    "sensor_msgs/msg/JointState": "JointState",
    "trajectory_msgs/msg/JointTrajectory": "Trajectory",
}
"""Messages that have a value of GRIP's own."""
_OWN = {*VALUE_OF.values(), "DepthImage"}
_MEASURED = {"Pose": LENGTHS, "PointCloud": LENGTHS, "JointState": ("rad", "deg")}
"""Values that a unit can be said of."""
_BUILTINS = {"bool": "bool", "string": "str", "wstring": "str", "float32": "float", "float64": "float"}


def port_type(field: FieldSpec) -> str:
    """Return the type of a field as a port that no component file declares."""
    item = "int" if field.type in INTEGER_TYPES else _BUILTINS.get(field.type, field.type)
    return f"list[{item}]" if field.array else item


def _field_at(side: Sequence[FieldSpec], path: str, fields_of: FieldsOf) -> FieldSpec | str | None:
    """Return the field at a dotted path, what is wrong with the path, or None where it isn't on this side or known."""
    first, *rest = path.split(".")
    field = _named(side, first)
    for at, name in enumerate(rest):
        if field is None:
            return None
        above = ".".join([first, *rest[:at]])
        if "/" not in field.type or field.array:
            return f"{above!r} is {field.spelling}, which has no fields, so {path!r} isn't there"
        inside = fields_of(field.type)
        if inside is None:
            return None
        field = _named(inside, name)
        if field is None:
            names = [f.name for f in inside]
            return f"{above!r} has no field {name!r}{nearest(name, names)} (it has: {listing(names)})"
    return field


def _faults(port: PortType, wanted: Type, field: FieldSpec, sent: bool, fields_of: FieldsOf) -> Iterator[str]:
    """Yield what is wrong with a port of one side of an interface, the request where it is `sent`."""
    if port.grasp is None and not _fits(wanted, field, port, sent, fields_of):
        usual = port_type(replace(field, type=VALUE_OF.get(field.type, field.type)))
        yield f"the field is {field.spelling}, which can't be `{wanted}`: write `{usual}`"
    innermost = wanted
    while innermost.item is not None:
        innermost = innermost.item
    inner = innermost.name
    if port.unit is not None:
        numbers = inner not in VALUES and inner not in ("bool", "str")
        if not (port.unit in _MEASURED[inner] if inner in _MEASURED else numbers) and not (
            port.grasp is not None and port.unit in LENGTHS
        ):
            others = "".join(f" and {value}s" for value, units in _MEASURED.items() if port.unit in units)
            yield f"`{wanted}` has nothing in {port.unit}; `unit` is for numbers{others}"
    if port.quaternion is not None and (inner != "Pose" or "/" in field.type):
        yield "`quaternion` is the order of a Pose's rotation in an array of numbers; messages have x, y, z, w by name"
    if port.frame is not None and inner in BUILTINS:
        yield f"`{wanted}` is in no frame; `frame` is for poses, clouds and grasps"


def _grasp_faults(said: GraspFields, component: ComponentFile, field: FieldSpec, fields_of: FieldsOf) -> Iterator[str]:
    """Yield what is wrong with how a field's messages say a grasp."""
    cameras = [n for n, p in component.ports.items() if p.type in ("DepthImage", "RgbdFrame", "CameraInfo")]
    if said.camera is not None and said.camera not in cameras:
        close, there_are = nearest(said.camera, cameras), listing(cameras, nothing="none")
        yield f"camera: {said.camera!r} isn't an input with a camera{close} (there are: {there_are})"
    vectors = (said.approach, said.closing) if said.position else ()
    numbers = [number.field for number in said.numbers().values()]
    for path in filter(None, (said.pose, said.position, *vectors, *numbers)):
        inside = (replace(field, name="grasp", array=False),)
        found = _field_at(inside, "grasp." + path.removeprefix("-"), fields_of)
        if isinstance(found, str):
            yield found.replace("'grasp'", field.type).replace("'grasp.", "'")
        elif found is not None and path in numbers and (found.array or "/" in found.type):
            yield f"{path} is {found.spelling}, which isn't a number"


def _fits(wanted: Type, field: FieldSpec, port: PortType, sent: bool, fields_of: FieldsOf) -> bool:
    """Tell whether a field may be of a type; what goes out as a message of somebody's own has fields of its names."""
    name, own = wanted.name, VALUE_OF.get(field.type)
    numbers = field.type in INTEGER_TYPES or field.type in ("float32", "float64")
    if name in ("Any", "dict", "bytes") or (name == "Pose" and field.array and numbers):
        return True  # a pose is 7 numbers, 4 or 3
    if field.array != (name == "list"):
        return False
    item = wanted.item if field.array else wanted
    if item is None or item.name == "Any":
        return True
    if "/" not in field.type:
        return item.name in _kinds(field.type, port, sent)
    if "/" in item.name:
        return item.name == field.type
    if item.name in BUILTINS:
        inside = fields_of(field.type)
        return inside is None or [f.name for f in inside] == ["data"]
    if item.name == "DepthImage" and own == "Image":
        return sent  # one that is received needs the camera's geometry too
    return own in (None, item.name) or item.name not in (_OWN if sent else VALUES)


def _kinds(primitive: str, port: PortType, sent: bool) -> tuple[str, ...]:
    """Return the types of ports that a primitive field can be."""
    if primitive in INTEGER_TYPES and port.unit is None:
        return ("int",) if sent else ("int", "float")
    if primitive in INTEGER_TYPES or primitive in ("float32", "float64"):
        return ("float", "int") if sent else ("float",)
    return ("bool",) if primitive == "bool" else ("str",)
