"""Synergies of a hand: the few ways in which its joints move together, found in postures (PCA).

Source: Santello, Flanders, Soechting, "Postural Hand Synergies for Tool Use", J. Neuroscience 18(23), 1998.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoContactError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import HandPort, Touch, TouchPoints
from grip_bt.base.values import JointState
from grip_bt.base.values.joints import Closing, ContactPoint, Span

from .taught import TaughtStates

_NOTHING = 1e-9


@dataclass(frozen=True)
class Synergies:
    """A linear space of postures: middle + weights @ directions.

    Attributes:
        names: n joints.
        middle: the mean of the postures, shape (n,) [rad].
        directions: shape (k, n) [rad], at right angles to one another, the strongest first; each as long as the
            postures reach, so that these have weights in [-1, 1].
    """

    names: tuple[str, ...]
    middle: Array
    directions: Array

    @classmethod
    def of(cls, postures: Iterable[JointState]) -> Synergies:
        """Find the synergies of postures of the same joints."""
        rows = list(postures)
        names = rows[0].names
        table = np.stack([row.ordered(names) for row in rows])
        middle = table.mean(axis=0)
        axes = np.linalg.svd(table - middle, full_matrices=False)[2]
        reach = np.abs((table - middle) @ axes.T).max(axis=0)
        kept = reach > _NOTHING
        # The sign of an axis is arbitrary: a positive weight goes the way in which the joints flex altogether.
        signs = np.where(axes.sum(axis=1) < 0, -1.0, 1.0)
        return cls(names, middle, (axes * (reach * signs)[:, None])[kept])

    def posture(self, weights: Sequence[float]) -> JointState:
        """Return the posture of some weights; those that aren't given are 0.

        Raises:
            ValueError: there are more weights than synergies, or one isn't finite.
        """
        given = np.asarray(weights, dtype=float)
        if given.ndim != 1 or len(given) > len(self.directions) or not np.isfinite(given).all():
            raise ValueError(f"weights are at most {len(self.directions)} finite numbers, not {list(weights)}")
        return JointState(self.names, self.middle + given @ self.directions[: len(given)])


Reach = Callable[[Mapping[str, Sequence[float]], JointState, str], JointState]
"""Targets, a posture to begin at, a frame (empty for the hand's grasp frame) -> posture."""
SpansOf = Callable[[Sequence[JointState]], Sequence[Span]]
OPENING_TIME = 0.8
CLOSING_TIME = 1.2
GOAL_TOLERANCE, AT_GOAL_TIME = 1e-3, 0.05
"""A hand all of whose joints are as near to their goal as this [rad or m] opens in this time [s]."""
STEPS = 33
"""From open to closed."""
TOUCH = 0.1
"""A contact counts from this force on [N]; solvers report whispers."""


class HandCommander:
    """Implements `ports.Hand`.

    Args:
        name: the hand's name in the project.
        port: moves the fingers.
        postures: name -> joint positions; `open` and `closed` exist.
        fingers: finger -> its joints; without it, they can't be moved one by one.
        limits: joint -> smallest and largest position [rad], for synergies; without it, the postures' own range.
        taught: what was taught before; nothing when None.
        reach: returns the posture, near another, that brings fingertips or links to positions in a frame; see
            `kinematics.fingertips.fingertip_posture`. Without it, the hand's geometry isn't known.
        spans: likewise, what is between the fingers in postures; see `kinematics.fingertips.spans_of`.
        touch: what the hand feels; without it, contacts are the port's, and slip isn't known.
    """

    def __init__(
        self,
        name: str,
        port: HandPort,
        postures: Mapping[str, JointState],
        fingers: Mapping[str, Sequence[str]] | None = None,
        limits: Mapping[str, tuple[float, float]] | None = None,
        taught: TaughtStates | None = None,
        reach: Reach | None = None,
        spans: SpansOf | None = None,
        touch: Touch | None = None,
    ):
        self._touch = touch
        self._reach, self._measure = reach, spans
        self.name, self._port, self.state, self._postures = name, port, port.state, dict(postures)
        self._fingers = {finger: tuple(joints) for finger, joints in (fingers or {}).items()}
        self._limits = dict(limits or {})
        self._taught = taught if taught is not None else TaughtStates()
        self._closing: Closing | None = None

    def named_states(self) -> Mapping[str, JointState]:
        return {**self._taught.states(self.name), **self._postures}

    def fingers(self) -> Mapping[str, tuple[str, ...]]:
        return dict(self._fingers)

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link of the hand that touches something, from 0.1 N on."""
        felt = self._port.contacts() if self._touch is None else self._touch.contacts()
        return {link: force for link, force in felt.items() if force >= TOUCH}

    def contact_points(self) -> Sequence[ContactPoint]:
        """Return where the hand presses on something; nothing where only forces are felt, as a real one's are."""
        return self._port.contact_points() if isinstance(self._port, TouchPoints) else ()

    def slips(self) -> Mapping[str, float]:
        if self._touch is None:
            raise SensorError(f"hand {self.name!r} has no sensors of slip; over ROS, `ros: controllers` names them")
        return self._touch.slips()

    def open(self, posture: JointState | str = "open") -> Operation[JointState]:
        goal, here = self._posture(posture), self._port.state()
        at_goal = np.abs(here.ordered(goal.names) - goal.position).max(initial=0.0) < GOAL_TOLERANCE
        return self.move(goal, seconds=AT_GOAL_TIME if at_goal else OPENING_TIME)

    def close(
        self, posture: JointState | str = "closed", torque_limit: float | None = None, force: float | None = None
    ) -> Operation[JointState]:
        if torque_limit is not None and force is not None:
            raise ValueError(f"hand {self.name!r}: closes with at most a torque, or to a force, not with both")
        goal = self._posture(posture)
        return self.move(goal, torque_limit, CLOSING_TIME, force).then(lambda measured: self._held(goal, measured))

    def closing(self) -> Closing | None:
        return self._closing

    def move(
        self,
        posture: JointState | str,
        torque_limit: float | None = None,
        seconds: float | None = None,
        force: float | None = None,
    ) -> Operation[JointState]:
        for what, number in (("torque limit [N m]", torque_limit), ("time [s]", seconds), ("force [N]", force)):
            if number is not None and not 0 < number < np.inf:
                raise ValueError(f"hand {self.name!r}: a {what} is a positive number, not {number}")
        goal = self._posture(posture)
        self._closing = None
        return self._port.move(goal, seconds or OPENING_TIME, torque_limit, force)

    def finger_posture(self, closing: Mapping[str, float]) -> JointState:
        for finger, share in closing.items():
            if finger not in self._fingers:
                raise UnknownNameError("finger", finger, self._fingers, where=f"hand {self.name!r}")
            if not 0 <= share <= 1:
                raise ValueError(f"hand {self.name!r}: finger {finger!r} closes from 0 to 1, not {share}")
        start, end = self._postures["open"].as_mapping(), self._postures["closed"].as_mapping()
        part = {joint: share for finger, share in closing.items() for joint in self._fingers[finger]}
        return JointState.from_mapping({j: start[j] + (end[j] - start[j]) * share for j, share in part.items()})

    def fingertip_posture(self, targets: Mapping[str, Sequence[float]], frame: str = "") -> JointState:
        for name, position in targets.items():
            if len(position) != 3 or not np.isfinite(position).all():
                raise ValueError(
                    f"hand {self.name!r}: {name!r} goes to a position of 3 finite numbers [m], not to {list(position)}"
                )
        if self._reach is None:
            raise ValueError(f"hand {self.name!r}: its geometry isn't known, so its fingertips can't be placed")
        return self._reach(targets, self._port.state(), frame)

    def spans(self, opened: str = "open", closed: str = "closed") -> Sequence[Span]:
        if self._measure is None:
            raise ValueError(f"hand {self.name!r}: its geometry isn't known, so no grasps can be proposed for it")
        start, goal = self._posture(opened), self._posture(closed)
        way = np.linspace(start.position, goal.ordered(start.names), STEPS)
        return tuple(self._measure([JointState(start.names, each) for each in way]))

    def synergy(self, weights: Sequence[float]) -> JointState:
        opened = self._postures["open"].as_mapping()  # what a posture doesn't name is as in `open`
        postures = [JointState.from_mapping(opened | posture.as_mapping()) for posture in self._postures.values()]
        made = Synergies.of(postures).posture(weights)
        table = np.stack([posture.position for posture in postures])
        ranges = zip(made.names, table.min(axis=0), table.max(axis=0), strict=True)
        low, high = np.array([self._limits.get(name, (least, most)) for name, least, most in ranges]).T
        return JointState(made.names, np.clip(made.position, low, high))

    def teach(self, name: str) -> JointState:
        state = self._port.state()
        measured = JointState(state.names, state.position)
        self._taught.put(self.name, name, measured, self._postures)
        return measured

    def stop(self) -> None:
        self._port.stop()

    def _held(self, goal: JointState, measured: JointState) -> Operation[JointState]:
        self._closing = Closing(goal, measured)
        if self.contacts():
            return Operation.finished(measured)
        return Operation.failed(NoContactError(f"hand {self.name!r} closed without touching anything"))

    def _posture(self, posture: JointState | str) -> JointState:
        if isinstance(posture, str):
            known = self.named_states()
            if posture not in known:
                raise UnknownNameError("posture", posture, known, where=f"hand {self.name!r}")
            posture = known[posture]
        positions = self._port.state().as_mapping()
        for joint, position in posture.as_mapping().items():
            if joint not in positions:
                raise UnknownNameError("joint", joint, positions, where=f"hand {self.name!r}")
            positions[joint] = position
        return JointState.from_mapping(positions)
