"""Leaves over ROS itself: topics, frames and parameters, named in the task."""

from __future__ import annotations

import math
from collections.abc import Mapping

from grip_bt.base.errors import DataError, GripError
from grip_bt.base.operation import Operation
from grip_bt.base.types import Value
from grip_bt.base.values import Pose
from grip_bt.task.catalog import parse_type

from .leaf import OperationLeaf, Status


class WaitForMessage(OperationLeaf):
    """Wait for the next message of a topic."""

    def prepare(self) -> None:
        self.context.ros().check(self.params["topic"], self.params["type"])
        try:
            parse_type(self.params["value"])
        except ValueError as error:
            raise GripError(f"value: {error}") from None

    def start(self) -> Operation[Value]:
        p = self.params
        limit = math.inf if p["timeout"] is None else p["timeout"]
        return self.context.ros().next(p["topic"], p["type"], p["value"], limit)


class LatestMessage(WaitForMessage):
    """Take the last message of a topic, when it is fresh enough, else wait for the next."""

    def prepare(self) -> None:
        super().prepare()
        self.context.ros().listen(self.params["topic"], self.params["type"])

    def start(self) -> Operation[Value]:
        p = self.params
        return self.context.ros().recent(p["topic"], p["type"], p["value"], p["max_age"], p["timeout"])


class WaitForMessages(OperationLeaf):
    """Wait for a message of each of several topics, taken at one moment."""

    def prepare(self) -> None:
        for topic, message in self.params["topics"].items():
            self.context.ros().check(topic, message)

    def start(self) -> Operation[Mapping[str, Value]]:
        return self.context.ros().together(self.params["topics"], self.params["slop"], self.params["timeout"])

    def finish(self, result: Mapping[str, Value]) -> Status:
        return self.end(messages=dict(result))


class Publish(OperationLeaf):
    """Publish a value as a message."""

    def prepare(self) -> None:
        self.context.ros().check(self.params["topic"], self.params["type"])

    def start(self) -> Operation[None]:
        p = self.params
        return self.context.ros().publish(p["topic"], p["type"], self.read("value"), p["subscribers"], p["timeout"])


class LookUpTransform(OperationLeaf):
    """Find where a frame is in another."""

    def start(self) -> Operation[Pose]:
        p, at = self.params, self.read("at")
        time = getattr(at, "time", at)
        if time is not None and (isinstance(time, bool) or not isinstance(time, (int, float))):
            raise DataError(self.path, "at", f"is a {type(at).__name__}: give seconds, or a picture or joint state")
        return self.context.ros().transform(p["target"], p["source"], p["timeout"], time)


class GetParameter(OperationLeaf):
    """Read a parameter of a node."""

    def prepare(self) -> None:
        self.context.ros().check(self.params["node"])

    def start(self) -> Operation[Value]:
        return self.context.ros().get_parameter(self.params["node"], self.params["name"], self.params["timeout"])


class SetParameter(GetParameter):
    """Set a parameter of a node."""

    def start(self) -> Operation[None]:
        p = self.params
        return self.context.ros().set_parameter(p["node"], p["name"], self.read("value"), p["timeout"])
