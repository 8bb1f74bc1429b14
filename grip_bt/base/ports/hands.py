"""What moves fingers, and hands as leaves ask for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState
from grip_bt.base.values.joints import Closing, ContactPoint, Span


@runtime_checkable
class HandPort(Protocol):
    """Moves the fingers of one hand."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of the hand."""

    def state(self) -> JointState:
        """Return the measured state, with efforts [N m] where they are known."""

    def move(
        self, posture: JointState, duration: float, torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        """Move the fingers towards a posture during `duration` [s] with at most `torque_limit` [N m].

        The result is the measured state when the time is over or all fingers have stopped moving, also when contact
        kept them from the posture. With a `force` [N] the hand presses with that, from then on until it moves again:
        half of all forces on what it holds, as two sides oppose each other.

        Raises:
            ValueError: the hand can't regulate a force.
        """

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link of the hand that touches something that isn't the robot."""

    def stop(self) -> None:
        """Hold the fingers where they are."""


@runtime_checkable
class Touch(Protocol):
    """What a hand feels with sensors of its own."""

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link that touches something; see `HandPort.contacts`."""

    def slips(self) -> Mapping[str, float]:
        """Return how fast what a link touches slides along it [m/s], lately or since it was asked before.

        Raises:
            SensorError: nobody measures that.
        """


@runtime_checkable
class TouchPoints(Protocol):
    """A hand that knows where it is touched."""

    def contact_points(self) -> Sequence[ContactPoint]:
        """Return where something presses on its links now, and how hard."""


@runtime_checkable
class Hand(Protocol):
    """What leaves ask of a hand."""

    @property
    def name(self) -> str:
        """The hand's name in the project."""

    def state(self) -> JointState:
        """Return the measured state of the hand's joints."""

    def named_states(self) -> Mapping[str, JointState]:
        """Return the hand's named postures; `open` and `closed` are among them."""

    def fingers(self) -> Mapping[str, tuple[str, ...]]:
        """Return the hand's fingers: name -> joints."""

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link of the hand that touches something."""

    def slips(self) -> Mapping[str, float]:
        """Return how fast something slides along each link [m/s]; see `Touch.slips`."""

    def open(self, posture: JointState | str = "open") -> Operation[JointState]:
        """Open to a posture, given or named."""

    def move(
        self, posture: JointState | str, torque_limit: float | None = None, seconds: float | None = None
    ) -> Operation[JointState]:
        """Move the fingers towards a posture, touching or not; joints that it doesn't name stay where they are.

        Raises:
            UnknownNameError: there is no such posture or joint.
            ValueError: the torque limit [N m] or the time isn't positive.
        """

    def finger_posture(self, closing: Mapping[str, float]) -> JointState:
        """Return the posture of some fingers: finger -> how far it is closed, 0 (as in `open`) to 1 (as in `closed`).

        Raises:
            UnknownNameError: there is no such finger.
            ValueError: a number isn't in [0, 1].
        """

    def fingertip_posture(self, targets: Mapping[str, Sequence[float]], frame: str = "") -> JointState:
        """Return the posture, near the present one, that brings fingertips or other links of the hand to positions.

        Takes up to some tenths of a second: not for a tick.

        Args:
            targets: finger or link -> position [m].
            frame: a link fixed to the palm, in which the positions are given; empty for the hand's grasp frame.

        Raises:
            NoIkError: they can't be reached; `data['distances']` tells how far they stay away, by name.
            UnknownNameError: there is no such finger, link or frame.
            ValueError: a position isn't 3 finite numbers, or the hand's geometry isn't known.
        """

    def spans(self, opened: str = "open", closed: str = "closed") -> Sequence[Span]:
        """Return what is between the fingers on their way between two named postures, in even steps.

        Raises:
            UnknownNameError: there is no such posture.
            ValueError: the hand's geometry isn't known, or it has less than two fingers.
        """

    def synergy(self, weights: Sequence[float]) -> JointState:
        """Return the posture of weights of the hand's synergies, kept within the joints' limits.

        Raises:
            ValueError: there are more weights than synergies, or one isn't finite.
        """

    def teach(self, name: str) -> JointState:
        """Remember the fingers' present posture as a named one, and return it; see `Arm.teach`."""

    def close(
        self, posture: JointState | str = "closed", torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        """Close towards a posture until the fingers stop, or press with a force [N]; see `HandPort.move`.

        Ends with NoContactError when nothing was touched.

        Raises:
            ValueError: the limit [N m] or the force isn't positive, both are given, or the hand regulates no force.
        """

    def closing(self) -> Closing | None:
        """Return what the hand did when it closed; None when it has moved in another way since, or never closed."""

    def stop(self) -> None:
        """Hold the fingers where they are."""
