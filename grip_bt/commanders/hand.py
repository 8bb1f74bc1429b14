"""The hand commander: named postures, and closing until something is held."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.errors import NoContactError, UnknownNameError
from grip_bt.operation import Operation
from grip_bt.ports import HandPort
from grip_bt.values import JointState

OPENING_TIME = 0.8
CLOSING_TIME = 1.2
TOUCH = 0.1
"""A contact counts from this force on [N]; solvers report whispers."""


class HandCommander:
    """Implements `ports.Hand`.

    Args:
        name: the hand's name in the project.
        port: moves the fingers.
        postures: name -> joint positions; `open` and `closed` exist.
        opening_time: duration of opening [s].
        closing_time: duration of closing without a contact [s].
    """

    def __init__(
        self,
        name: str,
        port: HandPort,
        postures: Mapping[str, JointState],
        opening_time: float = OPENING_TIME,
        closing_time: float = CLOSING_TIME,
    ):
        self._name, self._port, self._postures = name, port, dict(postures)
        self._opening_time, self._closing_time = opening_time, closing_time

    @property
    def name(self) -> str:
        """The hand's name in the project."""
        return self._name

    def state(self) -> JointState:
        """Return the measured state of the hand's joints."""
        return self._port.state()

    def named_states(self) -> Mapping[str, JointState]:
        """Return the hand's named postures."""
        return dict(self._postures)

    def open(self, posture: JointState | str = "open") -> Operation[JointState]:
        """Open to a posture, given or named; joints that it doesn't name stay where they are.

        Raises:
            UnknownNameError: there is no such posture or joint.
        """
        return self._port.move(self._posture(posture), self._opening_time)

    def close(self, posture: JointState | str = "closed", torque_limit: float | None = None) -> Operation[JointState]:
        """Close towards a posture until the fingers stop; the result is what was measured then.

        Ends with NoContactError when no link of the hand touches anything.

        Raises:
            UnknownNameError: there is no such posture or joint.
            ValueError: the torque limit isn't positive.
        """
        if torque_limit is not None and not torque_limit > 0:
            raise ValueError(f"hand {self._name!r}: a torque limit is positive, not {torque_limit} N m")
        return self._port.move(self._posture(posture), self._closing_time, torque_limit).then(self._held)

    def stop(self) -> None:
        """Hold the fingers where they are."""
        self._port.stop()

    def _held(self, measured: JointState) -> Operation[JointState]:
        contacts = {link: force for link, force in self._port.contacts().items() if force >= TOUCH}
        if contacts:
            return Operation.finished(measured)
        return Operation.failed(NoContactError(f"hand {self._name!r} closed without touching anything"))

    def _posture(self, posture: JointState | str) -> JointState:
        if isinstance(posture, str):
            if posture not in self._postures:
                raise UnknownNameError("posture", posture, self._postures, where=f"hand {self._name!r}")
            posture = self._postures[posture]
        positions = self._port.state().as_mapping()
        for joint, position in posture.as_mapping().items():
            if joint not in positions:
                raise UnknownNameError("joint", joint, positions, where=f"hand {self._name!r}")
            positions[joint] = position
        return JointState.from_mapping(positions)
