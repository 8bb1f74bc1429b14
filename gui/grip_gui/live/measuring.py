"""`python -m grip_gui.live.measuring WISH`: where an arm or a hand of the project here is now, as one line of JSON."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from grip_bt.app.project import find_project
from grip_bt.app.resources import open_resources
from grip_bt.errors import ExpectedError, GripError, MissingPartError, UnknownNameError
from grip_bt.ports import Arm, Hand

from .written import text_of


def measured(robot: str, part: str, what: str) -> Any:
    """Return what is measured, by the robot's adapters as a run gets them.

    Args:
        robot: `fake`, `sim` (which starts a world, and measures where its robot begins) or `ros`.
        part: an arm, or a hand.
        what: `joints`, or `pose` of the arm's grasp frame.

    Raises:
        GripError: it can't be measured; the message says why.
    """
    project = find_project(Path.cwd())
    if project.file.robot is None:
        raise MissingPartError("a robot", "name one in grip.yaml (`robot:`)")
    with open_resources(project, ["arm/teach"], robot, 0, None, lambda *_: None) as resources:
        parts: dict[str, Arm | Hand] = {**resources.hands, **resources.arms}
        if part not in parts:
            raise UnknownNameError("arm or hand", part, parts, "grip.yaml")
        if what == "pose":
            if part not in resources.arms:
                raise GripError(f"{part} is a hand: its joints can be kept; the pose of its palm is the arm's")
            return resources.arms[part].grasp_pose()
        return parts[part].state()


def main() -> int:
    """Print what is measured."""
    try:
        answer = {"text": text_of(measured(**json.loads(sys.argv[1])))}
    except ExpectedError as error:
        answer = {"trouble": error.message}
    except (GripError, ValueError, OSError) as error:
        answer = {"trouble": str(error)}
    sys.stdout.write("\n" + json.dumps(answer) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
