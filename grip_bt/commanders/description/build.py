"""A `RobotDescription` of a checked URDF, its SRDF and what a configuration says on top."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from grip_bt.base.errors import DocumentError, MissingPartError, UnknownNameError
from grip_bt.base.issue import Issue
from grip_bt.base.values import JointState

from .check_urdf import BALL, INERTIA, NO_EFFORT, NO_SPEED, principal_moments
from .config import Drive, RobotConfig
from .files import errors, robot_issue
from .moveit_package import JointLimits
from .packages import Packages
from .robot import EndEffector, RobotDescription
from .roles import Roles, frame_of
from .srdf import Group, Srdf, check_srdf, resolve
from .tree import HELD, Joint, Tree
from .xml import numbers


def with_config(srdf: Srdf, config: RobotConfig) -> Srdf:
    """Return an SRDF with a configuration's groups and end effectors added; those of the same name are replaced."""
    groups = {
        name: Group(name, g.joints, g.links, (g.chain,) if g.chain else (), g.groups)
        for name, g in config.groups.items()
    }
    ends = {end.name: end for end in srdf.end_effectors}
    for name, end in config.end_effectors.items():
        ends[name] = EndEffector(name, end.group, end.parent_link, end.parent_group)
    return replace(srdf, groups={**srdf.groups, **groups}, end_effectors=tuple(ends.values()))


def with_states(srdf: Srdf, config: RobotConfig, tree: Tree) -> tuple[Srdf, list[Issue]]:
    """Return an SRDF with a configuration's states added, and what is wrong with it."""
    found = check_srdf(srdf, tree)
    if errors(found):
        return srdf, found
    joints = resolve(srdf, tree)
    states = {group: dict(named) for group, named in srdf.states.items()}
    for group, named in config.states.items():
        if group not in joints:
            error = UnknownNameError("group", group, joints, where="states")
            return srdf, [*found, robot_issue("error", "bad-state", str(error))]
        for name, positions in named.items():
            if not isinstance(positions, dict):
                mine = joints[group]
                if len(positions) != len(mine):
                    what = f"states/{group}/{name} lists {len(positions)} positions"
                    has = f"the group has {len(mine)} joints: {', '.join(mine)}"
                    return srdf, [*found, robot_issue("error", "bad-state", f"{what}, and {has}")]
                positions = dict(zip(mine, positions, strict=True))
            states.setdefault(group, {})[name] = positions
    srdf = replace(srdf, states=states)
    return srdf, [*found, *(f for f in check_srdf(srdf, tree) if f not in found)]


TURNS = 2 * math.pi
"""A continuous joint is planned within this on both sides [rad]."""


def normal(
    robot: ET.Element, name: str, folder: Path, packages: Packages, limits: Mapping[str, JointLimits]
) -> ET.Element:
    """Return a copy of a URDF without errors.

    Args:
        folder: that relative mesh paths start in.
        packages: for `package://`.
        limits: joint -> limits that override its own.
    """
    result = ET.Element("robot", name=name)
    result.extend(copy.deepcopy(e) for e in robot if e.tag in ("material", "link", "joint"))
    for link in result.findall("link"):
        _with_found_meshes(link, folder, packages)
        _with_inertia(link)
    links = {link.get("name") for link in result.findall("link")}
    for joint in result.findall("joint"):
        if joint.get("type") == "fixed" and joint.get("name") in links:  # Pinocchio can't tell the two apart
            joint.set("name", f"{joint.get('name')}_fixed")
        _with_limits(joint, limits.get(joint.get("name", ""), JointLimits()))
    return result


def _with_found_meshes(link: ET.Element, folder: Path, packages: Packages) -> None:
    """Make mesh paths absolute; leave out what is only seen and isn't there."""
    for visual in [*link.findall("visual"), *link.findall("collision")]:
        for mesh in visual.iter("mesh"):
            try:
                path = packages.resolve(mesh.get("filename", ""), folder)
            except MissingPartError:
                path = Path()
            mesh.set("filename", str(path))
            if visual.tag == "visual" and not path.is_file():
                link.remove(visual)


def _with_inertia(link: ET.Element) -> None:
    """Give a link of which the file says no inertia that of a small ball of its mass."""
    mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
    if mass is None or inertia is None or not (weight := float(mass.get("value", "0"))) > 0:
        return
    if principal_moments(*(float(inertia.get(name, "0")) for name in INERTIA))[0] <= 0:
        moment = repr(0.4 * weight * BALL**2)
        inertia.attrib.update(dict.fromkeys(INERTIA, "0") | {"ixx": moment, "iyy": moment, "izz": moment})


def _with_limits(joint: ET.Element, override: JointLimits) -> None:
    kind = joint.get("type", "")
    if kind in HELD:
        joint.set("type", "fixed")
    if joint.get("type") == "fixed":
        return
    if (axis := joint.find("axis")) is not None:
        x, y, z = numbers(axis, "xyz", 3, "1 0 0")
        length = math.hypot(x, y, z)
        axis.set("xyz", f"{x / length!r} {y / length!r} {z / length!r}")
    for dynamics in joint.findall("dynamics"):  # simulators take both or none
        for name in ("damping", "friction"):
            dynamics.set(name, dynamics.get(name, "0"))
    limit = joint.find("limit")
    if limit is None:
        limit = ET.SubElement(joint, "limit")
    if kind == "continuous":
        joint.set("type", "revolute")
        limit.set("lower", repr(-TURNS))
        limit.set("upper", repr(TURNS))
        limit.set("velocity", limit.get("velocity", repr(math.pi)))
    for key in ("lower", "upper", "velocity"):
        if (value := getattr(override, key)) is not None:
            limit.set(key, repr(value))
    unit = "m" if kind == "prismatic" else "rad"
    if float(limit.get("velocity", "0")) <= 0:
        limit.set("velocity", repr(NO_SPEED[unit]))
    if float(limit.get("effort", "0")) <= 0:
        limit.set("effort", repr(NO_EFFORT[unit]))


RISE = 0.5
"""A joint without an acceleration limit reaches its velocity limit in this time [s]."""


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
    known = Roles(tree, srdf, groups, config)
    mimics = tree.mimics()
    hand_joints = {joint for hand in known.hands for joint in groups[hand]}
    hand_joints |= {name for name, mimic in mimics.items() if mimic.joint in hand_joints}
    driven = [joint for joint in tree.joints.values() if joint.movable]
    given = drives_of(groups, config)
    made = RobotDescription(
        name=urdf.get("name", "robot"),
        urdf=ET.tostring(urdf, encoding="unicode"),
        base_link=tree.root,
        groups=groups,
        named_states=named_states_of(srdf, groups, tree),
        grasp_frame=known.grasp_frame,
        finger_links=known.fingers,
        drives={
            joint.name: given.get(joint.mimic.joint if joint.mimic else joint.name)
            or _drive(joint, joint.name in hand_joints)
            for joint in driven
        },
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
    outside = {j.name: q for j in driven if (q := _inside(j, 0.0)) and j.name not in (*made.at_rest, *mimics)}
    return replace(made, rest={**made.rest, **outside})


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
    return {j: drive for group, drive in reversed(config.drives.items()) for j in groups.get(group, ())}


def accelerations_of(groups: Mapping[str, tuple[str, ...]], tree: Tree, config: RobotConfig) -> dict[str, float]:
    """Return the acceleration limits that a configuration gives, by joint; a joint's own before its group's."""
    grouped = {joint: a for group, a in config.accelerations.items() for joint in groups.get(group, ())}
    return grouped | {name: a for name, a in config.accelerations.items() if name in tree.joints}


def _inside(joint: Joint, position: float) -> float:
    return min(max(position, joint.lower), joint.upper) if joint.movable else position


def _drive(joint: Joint, in_hand: bool) -> Drive:
    limit, armature, stiffness = joint.effort, 0.0, 40000.0 if joint.type == "prismatic" else 4000.0
    damping = stiffness / 10
    if in_hand:  # light fingers: what an Allegro hand's joints and a Panda's gripper hold well with
        if joint.type == "prismatic":
            stiffness, damping = 2000.0, 100.0
        else:
            stiffness, damping, limit, armature = 6.0, 0.3, min(limit, 5.0), 0.001
    return Drive(stiffness=stiffness, damping=damping, limit=limit, armature=armature)


def _acceleration(joint: Joint, limits: Mapping[str, JointLimits]) -> float:
    given = limits.get(joint.name, JointLimits()).acceleration
    return given if given is not None and given > 0 else joint.velocity / RISE


def with_additions(robot: RobotDescription, config: RobotConfig) -> RobotDescription:
    """Return a robot with what a configuration adds to it.

    Raises:
        DocumentError: an addition names something that isn't there.
        UnknownNameError: likewise.
    """
    tree = Tree.of(robot.urdf)
    known = Srdf(groups={name: Group(name, joints) for name, joints in robot.groups.items()})
    srdf, found = with_states(with_config(known, config), config, tree)
    if wrong := errors(found):
        raise DocumentError("; ".join(finding.message for finding in wrong), f"robot {robot.name}")
    groups = resolve(srdf, tree)
    states = {g: dict(named) for g, named in robot.named_states.items()}
    for group, named in named_states_of(srdf, groups, tree).items():
        states.setdefault(group, {}).update(named)
    own = {group: frame_of(frame) for group, frame in config.grasp_frames.items()}
    for frame in own.values():
        if frame.link not in tree.links:
            raise UnknownNameError("link", frame.link, tree.links, where=f"robot {robot.name}: grasp_frames")
    inherited = {
        group: robot.grasp_frames[first]
        for group, written in config.groups.items()
        if (first := next((g for g in written.groups if g in robot.grasp_frames), None)) is not None
    }
    return replace(
        robot,
        groups=groups,
        named_states=states,
        grasp_frames={**inherited, **robot.grasp_frames, **own},
        grasp_frame=next(iter(own.values()), robot.grasp_frame),
        finger_links={
            **robot.finger_links,
            **{f: v for fingers in config.fingers.values() for f, v in fingers.items()},
        },
        drives={**robot.drives, **drives_of(groups, config)},
        acceleration_limits={**robot.acceleration_limits, **accelerations_of(groups, tree, config)},
    )
