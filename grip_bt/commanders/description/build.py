"""A `RobotDescription` of a checked URDF, its SRDF and what a configuration adds."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from grip_bt.base.values import JointState

from ..moveit_package.settings import JointLimits
from ..robots.description import Drive, RobotDescription
from .config import RobotConfig
from .groups import resolve
from .roles import roles
from .srdf import Srdf
from .tree import Joint, Tree

RISE = 0.5
"""A joint without an acceleration limit reaches its velocity limit in so many seconds."""


def build(
    urdf: ET.Element,
    srdf: Srdf,
    config: RobotConfig,
    limits: Mapping[str, JointLimits] | None = None,
    initial: Mapping[str, float] | None = None,
) -> RobotDescription:
    """Return the description.

    Args:
        urdf: as `normal` returns it.
        srdf: without errors for it.
        config: what the project adds.
        limits: joint -> limits of a MoveIt package; accelerations and jerks are taken from here.
        initial: joint -> position at the start [rad or m].
    """
    tree = Tree(urdf)
    groups = resolve(srdf, tree)
    known = roles(tree, srdf, groups, config)
    mimics = tree.mimics()
    hand_joints = {joint for hand in known.hands for joint in groups[hand]}
    hand_joints |= {name for name, mimic in mimics.items() if mimic.joint in hand_joints}
    driven = [joint for joint in tree.joints.values() if joint.movable]
    given = drives_of(groups, config)
    return RobotDescription(
        name=urdf.get("name", "robot"),
        urdf=ET.tostring(urdf, encoding="unicode"),
        base_link=tree.root,
        groups=groups,
        named_states=named_states_of(srdf, groups, tree),
        grasp_frame=known.grasp_frame,
        hand_links=tuple(dict.fromkeys(link for links in known.hands.values() for link in links)),
        finger_links=known.fingers,
        drives={joint.name: given.get(_leader(joint)) or _drive(joint, joint.name in hand_joints) for joint in driven},
        acceleration_limits={joint.name: _acceleration(joint, limits or {}) for joint in driven}
        | accelerations_of(groups, tree, config),
        disabled_pairs=frozenset(p for p in srdf.disabled if p[0] in tree.links and p[1] in tree.links),
        grasp_frames=known.grasp_frames,
        hands=known.hands,
        mimics=mimics,
        rest={name: _inside(tree.joints[name], q) for name, q in (initial or {}).items() if name in tree.joints},
        end_effectors=known.end_effectors,
        jerk_limits={n: j for n, one in (limits or {}).items() if n in tree.joints and (j := one.jerk)},
    )


def named_states_of(srdf: Srdf, groups: Mapping[str, tuple[str, ...]], tree: Tree) -> dict[str, dict[str, JointState]]:
    """Return each group's states; a joint that a state leaves out stays at zero, or at its nearest limit."""
    return {
        group: {
            name: JointState(groups[group], [_inside(tree.joints[j], positions.get(j, 0.0)) for j in groups[group]])
            for name, positions in states.items()
        }
        for group, states in srdf.states.items()
    }


def drives_of(groups: Mapping[str, tuple[str, ...]], config: RobotConfig) -> dict[str, Drive]:
    """Return the drives that a configuration gives, by joint."""
    return {
        joint: Drive(drive.stiffness, drive.damping, drive.limit, drive.armature)
        for group, drive in reversed(config.drives.items())
        for joint in groups.get(group, ())
    }


def accelerations_of(groups: Mapping[str, tuple[str, ...]], tree: Tree, config: RobotConfig) -> dict[str, float]:
    """Return the acceleration limits that a configuration gives, by joint; a joint's own before its group's."""
    grouped = {joint: a for group, a in config.accelerations.items() for joint in groups.get(group, ())}
    return grouped | {name: a for name, a in config.accelerations.items() if name in tree.joints}


def _inside(joint: Joint, position: float) -> float:
    return min(max(position, joint.lower), joint.upper) if joint.movable else position


def _leader(joint: Joint) -> str:
    return joint.mimic.joint if joint.mimic is not None else joint.name


def _drive(joint: Joint, in_hand: bool) -> Drive:
    slides = joint.type == "prismatic"
    if in_hand:  # light fingers: what an Allegro hand's joints and a Panda's gripper hold well with
        return Drive(2000.0, 100.0, joint.effort) if slides else Drive(6.0, 0.3, min(joint.effort, 5.0), 0.001)
    return Drive(40000.0, 4000.0, joint.effort) if slides else Drive(4000.0, 400.0, joint.effort)


def _acceleration(joint: Joint, limits: Mapping[str, JointLimits]) -> float:
    given = limits.get(joint.name, JointLimits()).acceleration
    return given if given is not None and given > 0 else joint.velocity / RISE
