"""An external component behind the port `Component`: values in, a ROS call, a goal or a message, values out.

A port is a value in GRIP's units and its own frame; its field is what the component speaks. What the component file
declares (units, frames, orders) is done here, once, on both ways, and checked: nobody writes glue code.
"""

from __future__ import annotations

import dataclasses
from array import array
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from grip_bt.base.failures import BadReplyError, CanceledError, GoalAbortedError
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, PointCloud, Pose
from grip_bt.task.catalog.component_file import FEEDBACK, ComponentFile
from grip_bt.task.catalog.port_type import LENGTHS, UNITS, PortType
from grip_bt.task.catalog.ros_config import INTEGER_TYPES

from .client.action import ActionClient
from .client.goal import GoalEnd
from .client.service import ServiceClient
from .client.topic import TopicReader, TopicWriter
from .client.types import ConversionError, FieldType, InterfaceType, Message, check_field, field_types
from .convert import from_message, to_message
from .frames import ROOT, FrameError, FrameTree, frame_of, transformed
from .grasps import GraspReader, frame_id

Client = ServiceClient | ActionClient | TopicReader | TopicWriter


class RosComponent:
    """A service, an action or a topic; implements `grip_bt.base.ports.Component`.

    Args:
        frames: where frames are, for ports that name one.
    """

    def __init__(self, file: ComponentFile, client: Client, frames: FrameTree | None = None):
        self.file, self.client = file, client
        self._adapter = Adapter(file, frames)
        self._meaning = list(file.meanings().items())

    def call(self, request: Mapping[str, object]) -> Operation[Mapping[str, object]]:
        """Send the inputs; the result holds the outputs as the declared values, and the `outcome` of a contract.

        The `outcome` in the result is an integer within the declared ones. A field that can't be converted is left out
        when the outcome means failure, since such an answer often holds nothing of use. The last feedback of an action
        is the operation's progress; cancelling the operation cancels the goal.

        Ends with ServerLostError, ServerTimeOutError or BadReplyError, of an action also with GoalRejectedError,
        GoalAbortedError or CanceledError; with ConversionError when the request is wrong.
        """
        try:
            return self._begin(request)
        except ConversionError as error:
            return Operation.failed(error.below(f"component {self.file.name}: request"))
        except FrameError as error:
            return Operation.failed(error)

    def _begin(self, request: Mapping[str, object]) -> Operation[Mapping[str, object]]:
        client, timeouts, moves = self.client, self.file.timeouts, self.file.moves
        unpack = partial(self._unpack, request)
        limit = f" (`timeouts: {{call: {timeouts.call:g}}}` in component.yaml of {self.file.name})"
        if isinstance(client, ServiceClient):
            asked = self._adapter.pack(request, client.type.Request)
            return client.call(asked, timeouts.call, timeouts.ready, not moves, limit).then(unpack)
        if isinstance(client, ActionClient):
            goal = self._adapter.pack(request, client.type.Goal)
            cancel = timeouts.cancel
            sent = client.send(goal, timeouts.call, timeouts.ready, cancel_within=cancel, moves=moves, limit=limit)
            whole = sent.then(partial(self._unpack_end, request))
            whole.progress_through(self._feedback)
            return whole
        if isinstance(client, TopicReader):
            return client.next(timeouts.call).then(unpack)
        message = self._adapter.pack(request, client.type)
        return client.publish(message, 1, timeouts.ready).then(lambda _: Operation.finished({}))

    def _feedback(self, message: Message | None) -> object:
        declared = self.file.ports.get(FEEDBACK)
        if message is None or declared is None:
            return message
        try:
            return from_message(message, declared.type)
        except ConversionError:
            return message  # a progress that can't be shown is no reason to give the goal up

    def _unpack_end(self, request: Mapping[str, object], end: GoalEnd) -> Operation[Mapping[str, object]]:
        if end.status == "canceled":
            raise CanceledError(f"component {self.file.name}: the goal was canceled")
        if end.status == "aborted":
            fields = {f: getattr(end.result, f) for f in field_types(end.result.__class__)}
            plain = {f: v for f, v in fields.items() if isinstance(v, (bool, int, float, str)) and v}
            said = f" ({', '.join(f'{f}: {v}' for f, v in plain.items())})" if plain else ""
            raise GoalAbortedError(f"component {self.file.name}: the server aborted the goal{said}", result=plain)
        return self._unpack(request, end.result)

    def _unpack(self, request: Mapping[str, object], response: Message) -> Operation[Mapping[str, object]]:
        result: dict[str, object] = {}
        meaning = "success"
        if not self.file.rules:
            result["outcome"], meaning = self._outcome(response)
        fields = [f for f in field_types(type(response)) if self.file.rules or f != "outcome"]
        for port, path in self.file.port_fields(fields).items():
            try:
                result[port] = self._adapter.unpack(response, port, path, request)
            except ConversionError as error:
                if meaning == "success":
                    reason = f"component {self.file.name}: {error.below(f'response.{path}')}"
                    raise BadReplyError(reason, field=path) from None
        return Operation.finished(result)

    def _outcome(self, response: Message) -> tuple[int, str]:
        number = getattr(response, "outcome", None)
        if not isinstance(number, int):
            raise BadReplyError(f"component {self.file.name}: the response has no integer field 'outcome'")
        if not 0 <= number < len(self._meaning):
            names = ", ".join(f"{i} {name}" for i, (name, _) in enumerate(self._meaning))
            raise BadReplyError(
                f"component {self.file.name}: outcome {number} isn't one of the declared ones ({names}); declare it in "
                "component.yaml, or fix the server",
                outcome=number,
            )
        return number, self._meaning[number][1]


_ANGLES = ("rad", "deg")


class Adapter:
    """Ports of one component, as fields of its messages; `frames`: where frames are, for those that a port names."""

    def __init__(self, file: ComponentFile, frames: FrameTree | None = None):
        self._file, self._frames = file, frames or FrameTree()

    def pack(self, values: Mapping[str, object], cls: InterfaceType) -> Message:
        """Return a message of `cls` that holds the values of ports, and what is fixed.

        Raises:
            ConversionError: a value doesn't fit, with the field.
            FrameError: a frame isn't known.
        """
        fields: dict[str, object] = dict(self._file.fixed)
        for port, value in values.items():
            declared = self._file.ports.get(port)
            path = declared.field if declared is not None and declared.field else port
            if declared is not None and declared.adapts:
                try:
                    value = self._outwards(value, declared, _field_type(cls, path))
                except ConversionError as error:
                    raise error.below(path) from None
            _put(fields, path.split("."), value)
        return to_message(fields, cls)

    def unpack(self, message: Message, port: str, path: str, request: Mapping[str, object] = FrozenDict()) -> object:
        """Return a port's value from its field; `request`: what it is an answer to.

        Raises:
            ConversionError: the field isn't there, or isn't what the port says.
        """
        declared = self._file.ports.get(port)
        raw, frame = message, ""
        for name in path.split("."):
            frame = frame_id(raw) or frame
            check_field(type(raw), name)
            raw = getattr(raw, name)
        if declared is None:
            return raw.tolist() if isinstance(raw, (array, np.ndarray)) else raw  # a `list[int]` is a list
        if declared.grasp is not None:
            return GraspReader(declared, frame, request, self._frames, self._file.name).read(raw)
        if declared.type == "Pose" and not hasattr(raw, "get_fields_and_field_types"):
            value: object = _pose_from_numbers(raw, declared)
        else:
            value = from_message(raw, declared.type)
        return self._inwards(value, declared, raw) if declared.adapts else value

    def _outwards(self, value: object, port: PortType, kind: FieldType) -> object:
        if port.frame is not None:
            value = self._into(value, port.frame)
        if port.unit is not None:
            value = scaled(value, 1.0 / UNITS[port.unit], port.unit)
            value = nearest_whole(value) if kind.base in INTEGER_TYPES else value
        if isinstance(value, Pose) and kind.array:
            rotation = value.quaternion if port.quaternion == "wxyz" else np.roll(value.quaternion, -1)
            return [*map(float, value.position), *map(float, rotation)]
        return value

    def _inwards(self, value: object, port: PortType, raw: object) -> object:
        if port.unit is not None:
            value = scaled(value, UNITS[port.unit], port.unit)
        first = raw[0] if isinstance(raw, (list, tuple)) and raw else raw
        if port.frame is not None and not (frame_id(first) or frame_id(getattr(first, "pose", None))):
            value = _labelled(value, port.frame)
        return value

    def _into(self, value: object, frame: str) -> object:
        present = frame_of(value)
        if present is None or present == frame:
            return value
        try:
            return transformed(value, self._frames.lookup(frame, present))
        except FrameError as error:
            raise ConversionError("", f"it is given in {present!r} and wanted in {frame!r}: {error.message}") from None
        except TypeError as error:
            raise ConversionError("", str(error)) from None


def scaled(value: object, factor: float, unit: str) -> object:
    """Return a value whose lengths, or angles, or numbers are multiplied.

    Args:
        value: a number, numbers, or a value that has lengths (poses, clouds) or angles (joint states).
        unit: of which kind the numbers are, such as `mm`.

    Raises:
        ConversionError: the value has no such quantity.
    """
    if isinstance(value, bool) or value is None:
        raise ConversionError("", f"{value!r} has no unit")
    if isinstance(value, (int, float, np.number)):
        return float(value) * factor
    if isinstance(value, Pose) and unit in LENGTHS:
        return Pose(value.position * factor, value.quaternion, value.frame)
    if isinstance(value, PointCloud) and unit in LENGTHS:
        return dataclasses.replace(value, points=value.points * np.float32(factor))
    if isinstance(value, JointState) and unit in _ANGLES:
        return dataclasses.replace(value, position=value.position * factor)
    if isinstance(value, np.ndarray) or hasattr(value, "typecode"):
        return np.asarray(value, dtype=float) * factor
    if isinstance(value, (list, tuple)):
        return [scaled(item, factor, unit) for item in value]
    raise ConversionError("", f"a {type(value).__name__} has nothing in {unit}")


def nearest_whole(value: Any) -> Any:
    """Return numbers as the whole ones nearest to them: 12.3 mm is 12 for a component that counts millimetres."""
    if isinstance(value, (list, tuple)):
        return [nearest_whole(item) for item in value]
    return np.rint(value).astype(np.int64) if isinstance(value, np.ndarray) else round(value)


def _field_type(cls: type, path: str) -> FieldType:
    *parents, last = path.split(".")
    for name in parents:
        kind = check_field(cls, name)
        if kind.message is None or kind.array:
            raise ConversionError(name, f"{kind.base} has no fields, so {path!r} isn't there")
        cls = kind.message
    return check_field(cls, last)


def _put(fields: dict[str, Any], path: list[str], value: object) -> None:
    for name in path[:-1]:
        inner = fields.setdefault(name, {})
        if not isinstance(inner, dict):
            raise ConversionError(name, "it is given as a whole and in parts")
        fields = inner
    fields[path[-1]] = value


def _pose_from_numbers(raw: object, port: PortType) -> Pose:
    numbers = np.asarray(raw, dtype=float).reshape(-1)
    if len(numbers) not in (3, 4, 7):
        raise ConversionError("", f"a pose is 7 numbers (position, rotation), 3 or 4; these are {len(numbers)}")
    position = numbers[:3] if len(numbers) != 4 else np.zeros(3)
    rotation = numbers[-4:] if len(numbers) != 3 else np.array([1.0, 0, 0, 0])
    if port.quaternion != "wxyz" and len(numbers) != 3:
        rotation = np.roll(rotation, 1)
    try:
        return Pose(position, rotation, port.frame or ROOT)
    except ValueError as error:
        raise ConversionError("", str(error)) from None


def _labelled(value: object, frame: str) -> object:
    if isinstance(value, (list, tuple)):
        return [_labelled(item, frame) for item in value]
    if frame_of(value) is None:
        return value
    return transformed(value, Pose(frame=frame))
