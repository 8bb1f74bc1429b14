"""`python -m grip_gui.live.measuring`: where an arm or a hand of the project of this folder is now, as YAML."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.errors import GripError, MissingPartError, UnknownNameError
from grip_bt.base.message_store.yaml import text_of
from grip_bt.base.ports import Arm, Hand
from grip_bt.base.values import JointState
from grip_gui.processes import answer_question
from grip_gui.setup.settings_store import DIGITS

_NO_ARM = "{} is a hand: its joints can be kept; the pose of its palm is the arm's"


def measured(robot: str, part: str, what: str, joints: Mapping[str, float] | None = None) -> Any:
    """Return what is measured, by the robot's adapters as a run gets them.

    Args:
        robot: `fake`, `sim` (which starts a world, and measures where its robot begins) or `ros`.
        part: an arm, or a hand.
        what: `joints`, or `pose` of the arm's grasp frame.
        joints: with `robot` `run`, where the part's joints were measured [rad or m].

    Raises:
        GripError: it can't be measured; the message says why.
    """
    project = find_project(Path.cwd())
    if project.file.robot is None:
        raise MissingPartError("a robot", "name one in grip.yaml (`robot:`)")
    if joints is not None:
        from grip_bt.commanders.kinematics.model import RobotModel

        state = JointState.from_mapping(joints)
        if what == "joints":
            return state
        if part not in project.file.arms:
            raise GripError(_NO_ARM.format(part))
        return RobotModel(project.description()).grasp_pose(state, group=project.file.arms[part].group)
    with open_resources(Opening(project), ["arm/teach"], robot) as resources:
        parts: dict[str, Arm | Hand] = {**resources.hands, **resources.arms}
        if part not in parts:
            raise UnknownNameError("arm or hand", part, parts, "grip.yaml")
        if what == "pose":
            if part not in resources.arms:
                raise GripError(_NO_ARM.format(part))
            return resources.arms[part].grasp_pose()
        return parts[part].state()


if __name__ == "__main__":
    sys.exit(answer_question(lambda **question: {"text": text_of(measured(**question), DIGITS)}))
