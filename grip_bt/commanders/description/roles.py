"""Which groups are hands, which links are theirs, and where a hand takes things, as far as files tell.

SRDF knows end effectors; it knows no fingers and no grasp frame. What a configuration says comes first, and what it
doesn't say is told from the tree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of

from .config import FrameConfig, RobotConfig
from .robot import EndEffector, GraspFrame, RobotDescription
from .srdf import Srdf
from .tree import Joint, Tree


def frame_of(config: FrameConfig) -> GraspFrame:
    """Return a configured frame as a value."""
    return GraspFrame(config.link, Pose(config.xyz, quaternion_of(*config.rpy), config.link))


class Roles:
    """What groups of a robot are for, whose SRDF was checked.

    Attributes:
        end_effectors: with their arms found.
        hands: hand's group -> its links.
        fingers: finger -> its links, of all hands; the thumb last.
        grasp_frames: arm's group -> its grasp frame.
        grasp_frame: the robot's main one.

    Args:
        srdf: its groups as they are written.
        config: what the project says about it.
    """

    def __init__(self, tree: Tree, srdf: Srdf, groups: Mapping[str, tuple[str, ...]], config: RobotConfig):
        self.tree, self.srdf, self.groups, self.config = tree, srdf, groups, config
        self.mimics = tree.mimics()
        ends = [self._with_arm(end) for end in srdf.end_effectors]
        named = [end.group for end in ends if end.group and end.group != end.parent_group]
        if not named and not config.fingers:
            tools = {end.group for end in srdf.end_effectors}
            written = srdf.groups.items()
            named = [g for g, each in written if _sounds_like_a_hand(g) and not each.groups and g not in tools]
        hands = [g for g in dict.fromkeys([*named, *config.fingers]) if groups.get(g)]
        mounted = {end.group for end in ends}
        ends += filter(None, (self._mounted(hand) for hand in hands if hand not in mounted))
        mounts = {end.group: end.parent_link for end in ends}
        self.end_effectors = tuple(ends)
        self.hands = {hand: self._links(hand, mounts.get(hand, "")) for hand in hands}
        self.fingers: dict[str, tuple[str, ...]] = {}
        for hand in hands:
            for name, mine in (config.fingers.get(hand) or self._fingers(hand)).items():
                self.fingers[name if name not in self.fingers else f"{hand}_{name}"] = tuple(mine)
        of_hands = [frame_of(config.grasp_frames[hand]) for hand in hands if hand in config.grasp_frames]
        self.grasp_frames = frames = self._grasp_frames(of_hands)
        own = [*(frames[e.parent_group] for e in ends if e.parent_group in frames), *frames.values()]
        self.grasp_frame = next(iter([*own, *of_hands]), _at(tree.root))

    def _with_arm(self, end: EndEffector) -> EndEffector:
        """Fill in the arm's group, which SRDFs leave out: the smallest that moves the parent link.

        A group that moves its own parent link is an arm with a bare tool.
        """
        carrier = next((j.name for j in self.tree.upwards(end.parent_link) if j.movable), "")
        shared = set(self.groups.get(end.group, ())) & set(self.groups.get(end.parent_group, ()))
        if end.parent_group:  # a group that shares joints with its arm is the arm's last link, not a hand
            return replace(end, group="") if shared else end
        able = [g for g, joints in self.groups.items() if carrier in joints]
        arm = min(able, key=lambda g: len(self.groups[g]), default="")
        bare = end.group in able
        return EndEffector(end.name, "" if bare else end.group, end.parent_link, end.group if bare else arm)

    def _mounted(self, hand: str) -> EndEffector | None:
        """Return where a hand sits that no end effector names: on the last link that a group without its joints moves.

        What stands on the robot's base is on no arm.
        """
        mine = set(self.groups[hand])
        carrier = next((j for j in self.tree.upwards(self._first_joints(hand)[0].parent) if j.movable), None)
        able = [g for g, joints in self.groups.items() if carrier and carrier.name in joints and not mine & set(joints)]
        arm = min(able, key=lambda g: len(self.groups[g]), default=None)
        return None if arm is None or carrier is None else EndEffector(hand, hand, carrier.child, arm)

    def _links(self, hand: str, mount: str) -> tuple[str, ...]:
        """Return what a hand's joints move, and what they sit on down to the mount or the last joint of the arm."""
        moved = {link for joint in self._first_joints(hand) for link in self.tree.subtree(joint.child)}
        for name in self.groups[hand]:
            link = self.tree.joints[name].parent
            while link not in moved and link != mount:
                moved.add(link)
                joint = self.tree.above.get(link)
                if joint is None or joint.movable:
                    break
                link = joint.parent
        return tuple(link for link in self.tree.links if link in moved)

    def _first_joints(self, hand: str) -> list[Joint]:
        """Return the joints of a hand, followers included, that no other joint of it carries."""
        mine = set(self.groups[hand])
        mine |= {name for name, mimic in self.mimics.items() if mimic.joint in mine}
        joints = [joint for name, joint in self.tree.joints.items() if name in mine]
        return [j for j in joints if not any(above.name in mine for above in self.tree.upwards(j.parent))]

    def _fingers(self, hand: str) -> dict[str, tuple[str, ...]]:
        found = {joint.child: self.tree.subtree(joint.child) for joint in self._first_joints(hand)}
        if len(self.groups[hand]) == 1:  # one joint drives them: what carries fewer joints is a bar of the linkage
            carried = {f: sum(self.tree.above[link].movable for link in links) for f, links in found.items()}
            found = {f: links for f, links in found.items() if carried[f] == max(carried.values())}
        return dict(sorted(found.items(), key=lambda item: "thumb" in item[0].lower()))

    def _grasp_frames(self, of_hands: list[GraspFrame]) -> dict[str, GraspFrame]:
        frames = {}
        for group, joints in self.groups.items():
            if group in self.hands or not joints:
                continue
            carried = next((end.parent_link for end in self.end_effectors if end.parent_group == group), None)
            of_hand = (f for f in of_hands if any(joint.name in joints for joint in self.tree.upwards(f.link)))
            written = self.srdf.groups[group]
            if group in self.config.grasp_frames:
                frames[group] = frame_of(self.config.grasp_frames[group])
            elif (frame := next(of_hand, None)) is not None:
                frames[group] = frame
            elif carried or not written.groups:
                tip = written.chains[-1][1] if written.chains else self.tree.joints[joints[-1]].child
                frames[group] = _at(carried or tip)
        for group, written in self.srdf.groups.items():  # a group of groups takes the frame of its first arm
            first = next((g for g in written.groups if g in frames), None)
            if group not in frames and group not in self.hands and first is not None:
                frames[group] = frames[first]
        return frames


def _sounds_like_a_hand(group: str) -> bool:
    return any(word in group.lower() for word in ("hand", "gripper", "finger"))


def _at(link: str) -> GraspFrame:
    return GraspFrame(link, Pose((0.0, 0.0, 0.0), frame=link))


def arms_of(robot: RobotDescription) -> tuple[str, ...]:
    """Return the groups that are arms, none of which has a joint of another one.

    An arm is a chain that carries a hand or a tool. Of groups with a joint in common, such as an arm and the same arm
    with its torso, the one is taken that an end effector names, then one with four to seven joints, with named states.
    """
    tree = Tree.of(robot.urdf)
    carrying = {end.parent_group for end in robot.end_effectors}
    hands = {joint for hand in robot.hands for joint in robot.groups.get(hand, ())}

    def chained(joints: tuple[str, ...]) -> bool:
        ahead = [j.name for j in reversed(list(tree.upwards(tree.joints[joints[-1]].child)))]
        return [j for j in ahead if j in joints] == list(joints)

    able = [g for g, joints in robot.groups.items() if joints and not hands & set(joints) and chained(joints)]
    longest = max((len(robot.groups[g]) for g in able), default=0)
    able = [g for g in able if len(robot.groups[g]) >= min(3, longest) or g in carrying]

    def order(group: str) -> tuple[bool, bool, bool, int]:
        count = len(robot.groups[group])
        return group not in carrying, not 4 <= count <= 7, not robot.named_states.get(group), -count

    taken: list[str] = []
    for group in sorted(able, key=order):
        if not any(set(robot.groups[group]) & set(robot.groups[other]) for other in taken):
            taken.append(group)
    return tuple(group for group in robot.groups if group in taken)
