"""A fake sensor on topics: values of one moment, from a list."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import cycle
from typing import Any

from grip_bt.base.failures import ExpectedError, SensorError
from grip_bt.base.operation import Operation


class FakeSensor:
    """Implements `ports.Sensor`.

    Args:
        moments: what captures give, one after the other, again and again: the value of each output by its name; an
            error stands for a failed capture.
    """

    def __init__(self, moments: Iterable[Mapping[str, Any] | ExpectedError] = ()):
        self._moments = cycle(tuple(moments))

    def capture(self) -> Operation[Mapping[str, Any]]:
        """Take the next moment; SensorError where there is none."""
        moment = next(self._moments, SensorError("the fake sensor has nothing to give"))
        return Operation.failed(moment) if isinstance(moment, ExpectedError) else Operation.finished(moment)
