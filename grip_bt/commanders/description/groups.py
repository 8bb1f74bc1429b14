"""Groups as joints: what an SRDF's chains, links, joints and subgroups come to in a robot's tree."""

from __future__ import annotations

from collections.abc import Iterator

from .srdf import Group, Srdf
from .tree import Tree


def resolve(srdf: Srdf, tree: Tree) -> dict[str, tuple[str, ...]]:
    """Return the joints of each group that can be driven, from the base on, each once.

    Fixed, virtual, passive and mimicking joints belong to none. The SRDF has to be one that `check_srdf` finds no
    error in.
    """
    mimics = tree.mimics()
    return {
        name: tuple(
            dict.fromkeys(
                joint
                for joint in _named(group, srdf, tree)
                if joint in tree.joints
                and tree.joints[joint].movable
                and joint not in mimics
                and joint not in srdf.passive
            )
        )
        for name, group in srdf.groups.items()
    }


def _named(group: Group, srdf: Srdf, tree: Tree) -> Iterator[str]:
    todo, seen = [group], {group.name}
    while todo:
        part = todo.pop()
        for base, tip in part.chains:
            yield from (joint.name for joint in tree.chain(base, tip) or ())
        yield from part.joints
        yield from (tree.above[link].name for link in part.links if link in tree.above)
        inner = [name for name in part.groups if name not in seen]
        seen.update(inner)
        todo += [srdf.groups[name] for name in reversed(inner)]
