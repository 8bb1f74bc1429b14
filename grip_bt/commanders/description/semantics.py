"""What a configuration says in place of an SRDF, or on top of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from grip_bt.base.errors import DocumentError, UnknownNameError

from ..robots.description import EndEffector
from .config import RobotConfig
from .groups import resolve
from .srdf import Group, Srdf
from .tree import Tree


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


def with_states(srdf: Srdf, config: RobotConfig, tree: Tree) -> Srdf:
    """Return an SRDF without errors with a configuration's states added.

    Raises:
        DocumentError: a state lists another number of positions than its group has joints.
        UnknownNameError: there is no such group.
    """
    joints = resolve(srdf, tree)
    states = {group: dict(named) for group, named in srdf.states.items()}
    for group, named in config.states.items():
        if group not in joints:
            raise UnknownNameError("group", group, joints, where="states")
        for name, positions in named.items():
            states.setdefault(group, {})[name] = _by_joint(positions, joints[group], f"states/{group}/{name}")
    return replace(srdf, states=states)


def _by_joint(positions: dict[str, float] | list[float], joints: tuple[str, ...], where: str) -> Mapping[str, float]:
    if isinstance(positions, dict):
        return positions
    if len(positions) != len(joints):
        raise DocumentError(
            f"{where} lists {len(positions)} positions, and the group has {len(joints)} joints: {', '.join(joints)}"
        )
    return dict(zip(joints, positions, strict=True))
