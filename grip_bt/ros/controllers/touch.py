"""What sensors of a robot feel, on topics: how hard links of a hand press, what slips, the wrench at a wrist."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import reduce
from re import findall
from typing import Any

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import SensorError
from grip_bt.base.ports import HandPort
from grip_bt.task.catalog.ros_config import ControllerConfig, SignalConfig

from ..client.bus import Bus


class _Signal:
    def __init__(self, bus: Bus, config: SignalConfig, stale: float):
        self._config, self._stale, self._reader = config, stale, bus.reader(config.message, config.topic)
        self._reader.listen()

    def numbers(self) -> tuple[Any, Array]:
        """Return the last message, and the numbers of its field; SensorError: it is too old, or has none."""
        latest = self._reader.latest
        if latest is None or time.monotonic() - latest.time > self._stale:
            silent = f"nothing was heard within {self._stale:g} s; {self._reader.publishers()}"
            raise SensorError(f"{self._config.topic}: {silent}")
        try:
            return latest.message, _flat(reduce(_part, findall(r"\w+", self._config.field), latest.message))
        except (AttributeError, IndexError, TypeError, ValueError) as error:
            what = f"{self._config.message} has no numbers in `{self._config.field}` ({error})"
            raise SensorError(f"{self._config.topic}: {what}") from None


def _part(whole: Any, key: str) -> Any:
    return whole[int(key)] if key.isdigit() else getattr(whole, key)


def _flat(part: Any) -> Array:
    if hasattr(part, "get_fields_and_field_types"):
        return np.concatenate([_flat(getattr(part, name)) for name in part.get_fields_and_field_types()])
    return np.atleast_1d(np.asarray(part, float))


class TopicTouch:
    """Implements `grip_bt.base.ports.Touch` as a hand's controller says; without topics, contacts are the port's."""

    def __init__(self, bus: Bus, hand: HandPort, config: ControllerConfig, stale: float):
        self._hand = hand
        self._contacts = {link: _Signal(bus, each, stale) for link, each in config.contacts.items()}
        self._slips = {link: _Signal(bus, each, stale) for link, each in config.slips.items()}

    def contacts(self) -> Mapping[str, float]:
        return _lengths(self._contacts) if self._contacts else self._hand.contacts()

    def slips(self) -> Mapping[str, float]:
        """Return link -> how fast something slides along it [m/s]."""
        if not self._slips:
            raise SensorError("no sensors of slip are named; add `slips` to this hand under `ros: controllers`")
        return _lengths(self._slips)


def _lengths(signals: Mapping[str, _Signal]) -> dict[str, float]:
    found = {link: float(np.linalg.norm(signal.numbers()[1])) for link, signal in signals.items()}
    return {link: length for link, length in found.items() if length}


class TopicWrench:
    """A force-torque sensor on a topic of geometry_msgs/msg/WrenchStamped."""

    def __init__(self, bus: Bus, topic: str, stale: float):
        self._signal = _Signal(bus, SignalConfig(topic=topic, field="wrench"), stale)

    def __call__(self) -> tuple[str, Array]:
        """Return the frame, and force [N] and torque [N m] in its axes, shape (6,); SensorError: it is silent."""
        message, numbers = self._signal.numbers()
        return message.header.frame_id, numbers
