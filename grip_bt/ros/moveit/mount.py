"""How an arm of the project is called in MoveIt, and where its grasp frame sits on the robot."""

from __future__ import annotations

from dataclasses import dataclass

from grip_bt.base.values import Pose
from grip_bt.commanders.robots import RobotDescription


@dataclass(frozen=True)
class Mount:
    """One arm with its hand.

    Attributes:
        group: MoveIt's group of the arm's joints.
        joints: these joints.
        link: the link that the grasp frame is fixed to.
        frame: the grasp frame in that link.
        hand_links: links of the hand, which may touch what it holds.
    """

    group: str
    joints: tuple[str, ...]
    link: str
    frame: Pose
    hand_links: tuple[str, ...]

    @classmethod
    def of(cls, robot: RobotDescription, group: str, hand_group: str = "", moveit_group: str = "") -> Mount:
        """Return the mount of a group of the robot.

        Args:
            robot: whose arm.
            group: the arm's group.
            hand_group: group of the hand that it carries; empty for none.
            moveit_group: MoveIt's name of the arm's group; the same as ours by default.

        Raises:
            UnknownNameError: the robot has no such group.
        """
        frame = robot.grasp_frames.get(group, robot.grasp_frame)
        links = robot.hands.get(hand_group, robot.hand_links) if hand_group else ()
        return cls(moveit_group or group, robot.group(group), frame.link, frame.pose, tuple(links))

    def link_pose(self, grasp: Pose) -> Pose:
        """Return where the link is when the grasp frame is at `grasp`."""
        return grasp @ self.frame.inverse()
