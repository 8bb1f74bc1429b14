"""Whether a declared port can be made from its field: types, units, rotations and frames, before anything is sent.

Only what can never do is told. A message of somebody's own may have the fields that a value needs, so that of values in
unknown messages nothing is said; of the messages that have a value of GRIP's own, no other value can be made.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from grip_bt.base.errors import listing, nearest
from grip_bt.base.types import BUILTINS, VALUES, Type, parse_type
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.component_parts import PortType
from grip_bt.task.catalog.ros_config import INTEGER_TYPES, FieldSpec

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
_LENGTHS, _ANGLES = ("m", "cm", "mm", "in"), ("rad", "deg")
_MEASURED = {"Pose": _LENGTHS, "PointCloud": _LENGTHS, "JointState": _ANGLES}
"""Values that a unit can be said of."""
_BUILTINS = {"bool": "bool", "string": "str", "wstring": "str", "float32": "float", "float64": "float"}


def port_type(field: FieldSpec) -> str:
    """Return the type of a field as a port that no component file declares."""
    item = "int" if field.type in INTEGER_TYPES else _BUILTINS.get(field.type, field.type)
    return f"list[{item}]" if field.array else item


def misfits(component: ComponentFile, side: Sequence[FieldSpec], sent: bool, fields_of: FieldsOf) -> Iterator[str]:
    """Yield what is wrong with the ports of one side of an interface.

    Args:
        component: what is declared.
        side: fields of the request, or of the response.
        sent: whether it is the request.
        fields_of: the fields of a message.
    """
    for name, port in component.ports.items():
        field = _field_at(side, port.field or name, fields_of)
        if isinstance(field, str):
            yield f"ports: {name}: {field}"
        elif field is not None:
            yield from (f"ports: {name}: {fault}" for fault in _faults(port, field, sent, fields_of))


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


def _faults(port: PortType, field: FieldSpec, sent: bool, fields_of: FieldsOf) -> Iterator[str]:
    try:
        wanted = parse_type(port.type)
    except ValueError:
        return  # that is told already
    if (reason := _unlike(wanted, field, port, sent, fields_of)) is not None:
        yield f"the field is {field.spelling}, which can't be `{wanted}`: {reason}"
    inner = _innermost(wanted).name
    if port.unit is not None and not _measures(inner, port.unit):
        yield f"`{wanted}` has nothing in {port.unit}; `unit` is for numbers{_of_values(port.unit)}"
    if port.quaternion is not None and (inner != "Pose" or "/" in field.type):
        yield "`quaternion` is the order of a Pose's rotation in an array of numbers; messages have x, y, z, w by name"
    if port.frame is not None and inner in BUILTINS:
        yield f"`{wanted}` is in no frame; `frame` is for poses, clouds and grasps"


def _unlike(wanted: Type, field: FieldSpec, port: PortType, sent: bool, fields_of: FieldsOf) -> str | None:
    """Return what to write instead of a type that a field can never be; None where it may be."""
    name, own = wanted.name, VALUE_OF.get(field.type, field.type)
    if name in ("Any", "dict", "bytes") or (name == "Pose" and field.array and _is_number(field.type)):
        return None  # a pose is 7 numbers, 4 or 3
    if field.array != (name == "list"):
        return f"write `list[{_plain(own)}]`" if field.array else f"it is one, write `{_plain(own)}`"
    item = wanted.item if field.array else wanted
    if item is None or item.name == "Any":
        return None
    if "/" not in field.type:
        return None if item.name in _kinds(field.type, port, sent) else f"write `{_plain(own)}`"
    if "/" in item.name:
        return None if item.name == field.type else f"write `{own}`" + f", or `{field.type}`" * (own != field.type)
    if item.name in BUILTINS:
        inside = fields_of(field.type)
        return None if inside is None or [f.name for f in inside] == ["data"] else f"write `{own}`"
    if item.name == "DepthImage" and own == "Image":
        return None if sent else "a depth image needs the camera's geometry too; take it as `Image`"
    compared = _OWN if sent else VALUES  # of others, what goes out has fields of the same names
    return f"write `{own}`" if field.type in VALUE_OF and item.name in compared and item.name != own else None


def _is_number(primitive: str) -> bool:
    return primitive in INTEGER_TYPES or primitive in ("float32", "float64")


def _kinds(primitive: str, port: PortType, sent: bool) -> tuple[str, ...]:
    """Return the types of ports that a primitive field can be, the usual one first."""
    if primitive == "bool":
        return ("bool",)
    if primitive in INTEGER_TYPES:
        if port.unit is not None:
            return ("float", "int") if sent else ("float",)
        return ("int",) if sent else ("int", "float")
    if primitive in ("float32", "float64"):
        return ("float", "int") if sent else ("float",)
    return ("str",)


def _plain(name: str) -> str:
    """Return a primitive as a port spells it; anything else as it is."""
    return name if "/" in name or name in VALUES else _kinds(name, PortType(type="Any"), True)[0]


def _measures(name: str, unit: str) -> bool:
    if name in _MEASURED:
        return unit in _MEASURED[name]
    return name not in VALUES and name not in ("bool", "str")


def _of_values(unit: str) -> str:
    found = [f"{value}s" for value, units in _MEASURED.items() if unit in units]
    return f" and {' and '.join(found)}" if found else ""


def _innermost(wanted: Type) -> Type:
    while wanted.item is not None:
        wanted = wanted.item
    return wanted


def _named(fields: Sequence[FieldSpec], name: str) -> FieldSpec | None:
    return next((f for f in fields if f.name == name), None)
