"""What a configuration adds to a robot that is there already: groups, states, grasp frames, fingers, drives."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

from grip_bt.base.errors import DocumentError, UnknownNameError

from ..robots.description import RobotDescription
from .build import accelerations_of, drives_of, named_states_of
from .check_srdf import check_srdf
from .config import RobotConfig
from .findings import errors
from .groups import resolve
from .roles import frame_of
from .semantics import with_config, with_states
from .srdf import Group, Srdf
from .tree import Tree


def with_additions(robot: RobotDescription, config: RobotConfig) -> RobotDescription:
    """Return a robot with what a configuration adds to it.

    Raises:
        DocumentError: an addition names something that isn't there.
        UnknownNameError: likewise.
    """
    tree = Tree(ET.fromstring(robot.urdf))
    known = Srdf(groups={name: Group(name, joints) for name, joints in robot.groups.items()})
    srdf = with_config(known, config)
    if wrong := errors(check_srdf(srdf, tree)):
        raise DocumentError("; ".join(finding.message for finding in wrong), f"robot {robot.name}")
    srdf = with_states(srdf, config, tree)
    if wrong := errors(check_srdf(srdf, tree)):
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
