"""Leaves that take what a sensor on topics gives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.base.failures import SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Sensor

from .leaf import OperationLeaf, Status


class Sense(OperationLeaf):
    """Take one value of each output of the sensor that the manifest's `settings` name."""

    sensor: Sensor

    def prepare(self) -> None:
        """Look the sensor up."""
        self.sensor = self.context.sensor(self.manifest.settings["sensor"])

    def start(self) -> Operation[Mapping[str, Any]]:
        """Ask for values of one moment."""
        return self.sensor.capture()

    def finish(self, result: Mapping[str, Any]) -> Status:
        """Hand them out."""
        if missing := [port for port in self.manifest.outputs if port not in result]:
            raise SensorError(f"the sensor gave nothing for {', '.join(missing)}; it gave {', '.join(result)}")
        return self.end(**{port: result[port] for port in self.manifest.outputs})
