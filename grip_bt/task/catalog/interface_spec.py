"""A ROS interface as a plain value: what generators and checks need to know of a .msg, .srv or .action, without ROS.

The room `ros` reads it (`grip_bt.ros.interfaces.read_interface`); everything else only looks at it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["msg", "srv", "action"]

INTEGER_TYPES = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)) | {"byte", "char"}
"""Primitive types that hold whole numbers."""


@dataclass(frozen=True, slots=True)
class FieldSpec:
    """One field.

    Attributes:
        name: the field's name.
        type: a primitive (`float64`, `string`) or a full message name (`geometry_msgs/msg/Pose`).
        array: whether it holds several.
        size: how many, exactly or at most; None when it isn't bounded, or isn't an array.
        bounded: whether `size` is an upper bound rather than exact.
        doc: the comment beside it.
    """

    name: str
    type: str
    array: bool = False
    size: int | None = None
    bounded: bool = False
    doc: str = ""

    @property
    def spelling(self) -> str:
        """The type as an interface file spells it, such as `geometry_msgs/Pose[<=3]`."""
        if not self.array:
            return self.type.replace("/msg/", "/")
        size = "" if self.size is None else f"<={self.size}" if self.bounded else str(self.size)
        return f"{self.type.replace('/msg/', '/')}[{size}]"

    @property
    def is_integer(self) -> bool:
        """Whether it holds one whole number."""
        return self.type in INTEGER_TYPES and not self.array


@dataclass(frozen=True, slots=True)
class InterfaceSpec:
    """One interface.

    Attributes:
        package: the ROS package that defines it.
        kind: `msg`, `srv` or `action`.
        name: its name in the package.
        request: fields of the request or goal; of the message itself for a `msg`.
        response: fields of the response or result; empty for a `msg`.
        feedback: fields of the feedback of an `action`.
        doc: the comment at the top of the file.
        source: the file it was read from.
    """

    package: str
    kind: Kind
    name: str
    request: tuple[FieldSpec, ...] = ()
    response: tuple[FieldSpec, ...] = ()
    feedback: tuple[FieldSpec, ...] = ()
    doc: str = ""
    source: str = ""

    @property
    def type_name(self) -> str:
        """Its full name, such as `std_srvs/srv/Trigger`."""
        return f"{self.package}/{self.kind}/{self.name}"
