"""What a robot looks like, asked for in a process of its own, which loads the meshes."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from grip_bt.base.interpreter import python_command
from grip_bt.commanders.description.files import Stamps

from .robot_facts import read_from

PATIENCE = 60.0
"""How long the process may take [s]."""


def geometry(robot: object, hands: Mapping[str, str], folder: Path) -> dict[str, Any]:
    """Return what a robot looks like.

    Args:
        robot: what a project says of it.
        hands: hand -> its arm's group, to tell where what it holds is.
        folder: that relative paths begin in.

    Returns:
        `links`, `joints`, `meshes`, `rest`, `grasp`; only `error` where it can't be told.
    """
    if not robot:
        return {"error": "grip.yaml names no robot"}
    question = {"robot": robot, "hands": dict(hands), "folder": str(folder)}
    return _asked(json.dumps(question, sort_keys=True, default=str), read_from(robot, folder))


@lru_cache(maxsize=4)
def _asked(question: str, stamps: Stamps) -> dict[str, Any]:
    command = python_command("-m", "grip_gui.setup.robot_drawing")
    try:
        done = subprocess.run(command, input=question, capture_output=True, text=True, timeout=PATIENCE, check=False)
        return dict(json.loads(done.stdout.splitlines()[-1]))
    except (OSError, subprocess.TimeoutExpired, ValueError, IndexError) as error:
        return {"error": f"the robot can't be drawn: {error}"}
