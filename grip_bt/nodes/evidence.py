"""Whether a hand holds something: what its contacts, its fingers and a camera say of it, and how that is put together.

Each kind of evidence says yes, no, or nothing where it can't tell. The hand holds something when one of the hand itself
(contact, fingers, or the object seen in the hand) says yes and none says no: that a place is empty doesn't mean that
the hand holds what stood there, and contradicting evidence is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.errors import listing
from grip_bt.base.ports import Hand, Scene
from grip_bt.base.values import DepthImage, JointState, Pose
from grip_bt.nodes.camera_views import MARGIN, Change, Hulls, Mask, outline, robot_pixels, share

EMPTY = "empty"
"""A hand's named or taught posture that it closes to when nothing is in it."""
STILL = 1e-3
"""Joints that go a shorter way than this from open to closed [rad or m] don't count."""
SHIFT = 0.03
"""How far what is held may have shifted from where the scene has it [m]."""
_VISIBLE = 25
"""Fewer pixels of an object than this tell nothing."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What one kind of evidence says.

    Attributes:
        name: `contact`, `fingers`, `sight` or `image`.
        held: whether something is held; None where it can't tell.
    """

    name: str
    held: bool | None
    why: str

    def __str__(self) -> str:
        says = {True: "yes", False: "no", None: "can't tell"}[self.held]
        return f"{self.name}: {says}, {self.why}"


@dataclass(frozen=True, slots=True)
class EvidenceLimits:
    """From when on what a hand measures is evidence.

    Attributes:
        force: a contact counts from this force on [N].
        links: how many links have to touch.
        least_open: an empty hand is closed but for this share of the way from open to closed.
        most_moved: fingers that have moved by more than this share since something stopped them don't hold it any more.
    """

    force: float = 0.1
    links: int = 1
    least_open: float = 0.03
    most_moved: float = 0.05


def holds(evidence: Sequence[Evidence]) -> bool:
    """Put evidence together; see the module."""
    said = [one for one in evidence if one.held is not None]
    return all(v.held for v in said) and any(v.name != "image" for v in said)


def hand_evidence(hand: Hand, limits: EvidenceLimits) -> list[Evidence]:
    """Return what the hand itself says now."""
    links = sorted(link for link, pressed in hand.contacts().items() if pressed >= limits.force)
    said = f"{listing(links)} touched" if links else "nothing is touched"
    return [Evidence("contact", len(links) >= limits.links, said), fingers_evidence(hand, limits)]


def fingers_evidence(hand: Hand, limits: EvidenceLimits) -> Evidence:
    """Say whether something keeps the fingers from closing, as it did when they closed.

    The sums go over all joints. What is left of the way is compared with `empty`, where the hand has such a posture
    (an Allegro hand's fingers meet before they are closed), else with the posture that the fingers were sent to.
    """
    closing = hand.closing()
    if closing is None:
        return Evidence("fingers", None, "the hand wasn't closed by a node of this run")
    postures, names = hand.named_states(), closing.goal.names
    goal = closing.goal.ordered(names)
    empty = _posture(postures.get(EMPTY), names, goal)
    way = np.abs(goal - _posture(postures.get("open"), names, goal))
    counts = way > STILL
    if not counts.any():
        return Evidence("fingers", None, "it was closed to where it is open")
    total = float(way[counts].sum())
    now, stopped = hand.state().ordered(names), closing.reached.ordered(names)
    left = float(np.abs(now - empty)[counts].sum()) / total
    moved = float((np.abs(stopped - goal) - np.abs(now - goal))[counts].sum()) / total
    if left < limits.least_open:
        return Evidence("fingers", False, f"closed as without anything ({left:.1%} of the way is left)")
    if abs(moved) > limits.most_moved:
        how = "closed" if moved > 0 else "opened"
        return Evidence("fingers", False, f"{how} by {abs(moved):.1%} of the way since something stopped them")
    return Evidence("fingers", True, f"stopped {left:.1%} of the way before they are closed, {moved:+.1%} since")


def _posture(state: JointState | None, names: tuple[str, ...], default: NDArray[np.float64]) -> NDArray[np.float64]:
    known = {} if state is None else state.as_mapping()
    return np.array([known.get(name, other) for name, other in zip(names, default.tolist(), strict=True)])


def sight_evidence(depth: DepthImage, scene: Scene, hand: str, hulls: Hulls) -> Evidence:
    """Say whether a camera sees, where the hand holds it, what the scene has attached to the hand.

    The image was taken with the arm where it is now; the hulls are the robot's, see `ports.Scene.robot`.
    """
    attached = scene.attached(hand)
    if not attached:
        return Evidence("sight", None, "the scene has nothing attached to the hand")
    size, pose = scene.box(attached[0])
    box = _corners(size, pose)
    info = depth.info
    seen: Mask = outline(info, [box]) & ~robot_pixels(depth, hulls)
    if seen.sum() < _VISIBLE:
        return Evidence("sight", None, "the camera doesn't see what would be in the hand")
    away = (box - info.pose.position) @ info.pose.rotation()[:, 2]
    slack = SHIFT + MARGIN
    there = (depth.depth > away.min() - slack) & (depth.depth < away.max() + slack)
    part = share(there, seen)
    if part >= 0.4:
        return Evidence("sight", True, f"seen in the hand ({part:.0%} of where it would show)")
    return Evidence("sight", False if part < 0.15 else None, f"{part:.0%} of where it would show in the hand shows it")


def _corners(size: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return pose.apply(signs * np.asarray(size) / 2)


def image_evidence(change: Change, min_vacated: float, max_appeared: float, min_pixels: int = _VISIBLE) -> Evidence:
    """Say whether the object has left its place, and isn't elsewhere on the table.

    Limits: the smallest fraction of the object's pixels that must be empty now, the largest area that may have appeared
    elsewhere, as such a fraction too, and how many pixels of the object before the pick are evidence at all.
    """
    vacated, appeared = change.vacated, change.appeared
    if change.object_pixels < min_pixels:
        text = f"only {change.object_pixels} pixels showed an object before the pick; {min_pixels} are needed"
        return Evidence("image", None, text)
    if vacated < min_vacated:
        text = f"only {vacated:.0%} of the object's place is empty; {min_vacated:.0%} are needed"
        return Evidence("image", False, text)
    if appeared > max_appeared:
        text = f"something as large as {appeared:.0%} of the object appeared elsewhere on the table"
        return Evidence("image", False, text)
    return Evidence("image", True, f"{vacated:.0%} of the object's place is empty")
