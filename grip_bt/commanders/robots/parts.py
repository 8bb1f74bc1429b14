"""Arms and hands before they are put together, and the one function that does it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from grip_bt.base.errors import MissingPartError
from grip_bt.base.values import JointState

from .assembly import Mount, cut_below, load_urdf, mounted
from .description import Drive, GraspFrame, RobotDescription

PACKAGE = "example-robot-data"


@dataclass(frozen=True, slots=True)
class ArmPart:
    """An arm without a hand. Paths are relative to the `robots` folder of example-robot-data.

    Attributes:
        name: the arm's name.
        urdf: path of its URDF.
        base_link: the link that stands at the world's origin.
        flange: the link that carries the hand; what hangs on it in the URDF is cut off.
        joints: its joints, in order.
        drive: stiffness, damping and limit of every joint.
        accelerations: largest acceleration of each joint [rad/s^2].
        srdf: path of an SRDF whose disabled collision pairs hold, or empty.
    """

    name: str
    urdf: str
    base_link: str
    flange: str
    joints: tuple[str, ...]
    drive: Drive
    accelerations: tuple[float, ...]
    srdf: str = ""


@dataclass(frozen=True, slots=True)
class HandPart:
    """A hand without an arm; names are those of its own URDF, without a prefix.

    Attributes:
        name: the hand's name.
        urdf: path of its URDF.
        root: its root link.
        joints: its joints, in order.
        drive: stiffness, damping, limit and armature of every joint.
        accelerations: largest acceleration of each joint [rad/s^2].
        postures: name -> joint positions; `open` and `closed` exist.
        grasp_frame: its grasp frame.
        fingers: finger -> its links from the knuckle to the tip, thumb last.
    """

    name: str
    urdf: str
    root: str
    joints: tuple[str, ...]
    drive: Drive
    accelerations: tuple[float, ...]
    postures: Mapping[str, tuple[float, ...]]
    grasp_frame: GraspFrame
    fingers: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def assemble(
    arm: ArmPart, hand: HandPart, mount: Mount, arm_states: Mapping[str, tuple[float, ...]]
) -> RobotDescription:
    """Put a hand on an arm.

    Args:
        hand: the hand; its links and joints get the prefix `hand_`.
        mount: where the hand sits on the arm's flange.
        arm_states: name -> positions of the arm's joints [rad]; `home` among them.

    Raises:
        MissingPartError: example-robot-data isn't installed.
    """
    prefix, name = "hand_", f"{arm.name}_{hand.name}"
    folder = asset_folder() / "robots"
    packages = {PACKAGE: asset_folder()}
    bare_arm = cut_below(load_urdf(folder / arm.urdf, packages), arm.flange)
    hand_tree = load_urdf(folder / hand.urdf, packages)
    robot = mounted(bare_arm, hand_tree, mount, prefix, name)
    joints = tuple(prefix + j for j in hand.joints)
    links = {e.get("name", "") for e in robot.findall("link")}
    return RobotDescription(
        name=name,
        urdf=ET.tostring(robot, encoding="unicode"),
        base_link=arm.base_link,
        groups={"arm": arm.joints, "hand": joints},
        named_states={
            "arm": {s: JointState(arm.joints, q) for s, q in arm_states.items()},
            "hand": {s: JointState(joints, q) for s, q in hand.postures.items()},
        },
        grasp_frame=replace(hand.grasp_frame, link=prefix + hand.grasp_frame.link),
        hand_links=tuple(prefix + e.get("name", "") for e in hand_tree.findall("link")),
        finger_links={f: tuple(prefix + k for k in links) for f, links in hand.fingers.items()},
        drives=dict.fromkeys(arm.joints, arm.drive) | dict.fromkeys(joints, hand.drive),
        acceleration_limits=dict(zip(arm.joints + joints, arm.accelerations + hand.accelerations, strict=True)),
        disabled_pairs=_disabled_pairs(folder / arm.srdf, links) if arm.srdf else frozenset(),
    )


@cache
def asset_folder() -> Path:
    """Return the folder of example-robot-data on this machine.

    The wheel carries no Python module, so its list of files tells where it is.

    Raises:
        MissingPartError: it isn't installed.
    """
    try:
        files = distribution(PACKAGE).files or []
    except PackageNotFoundError as error:
        raise MissingPartError(f"{PACKAGE} (robot models)", "pip install 'grip-bt[motion]'") from error
    for file in files:
        if str(file).endswith(f"{PACKAGE}/package.xml"):
            return Path(str(file.locate())).resolve().parent
    raise MissingPartError(f"the data of {PACKAGE}", f"pip install --force-reinstall {PACKAGE}")


def _disabled_pairs(srdf: Path, links: set[str]) -> frozenset[tuple[str, str]]:
    """Return the disabled pairs among `links`; the SRDF may speak of a gripper that was cut off."""
    elements = ET.parse(srdf).getroot().findall("disable_collisions")
    pairs = (sorted((e.get("link1", ""), e.get("link2", ""))) for e in elements)
    return frozenset((a, b) for a, b in pairs if a in links and b in links)
