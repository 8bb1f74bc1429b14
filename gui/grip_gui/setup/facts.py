"""What may stand in a project's fields: robots, planners, solvers, groups, named states. Asked in a process of its own.

Robot descriptions load native code; a broken one must not take the editor down.
"""

from __future__ import annotations

import json
import subprocess
import sys
from functools import lru_cache
from typing import Any

PATIENCE = 60.0
"""How long the process may take [s]."""


@lru_cache(maxsize=16)
def facts(robot: str) -> dict[str, Any]:
    """Return what is known about a ready-made robot, and about planning; what can't be found out is left out.

    Args:
        robot: its name; empty for none.

    Returns:
        `robots`, `planners`, `kinematics`: names; `groups`: group -> joints; `states`: group -> names.
    """
    command = [sys.executable, "-c", "from grip_gui.setup.facts import tell; tell()", robot]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
        found = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else {}
    except (OSError, subprocess.TimeoutExpired, ValueError, IndexError):
        return {}
    return dict(found)


def tell() -> None:
    """Print what is known about the robot that the command line names, as one line of JSON."""
    sys.stdout.write(json.dumps(_gathered(sys.argv[1])) + "\n")


def _gathered(robot: str) -> dict[str, Any]:
    from grip_bt.commanders.ik import SOLVERS
    from grip_bt.commanders.planning.free import planners
    from grip_bt.commanders.robots import ROBOTS, build_robot
    from grip_bt.errors import GripError

    found: dict[str, Any] = {"robots": list(ROBOTS), "planners": sorted(planners()), "kinematics": list(SOLVERS)}
    try:
        description = build_robot(robot)
    except GripError:
        return found
    found["groups"] = {group: list(joints) for group, joints in description.groups.items()}
    found["states"] = {group: list(states) for group, states in description.named_states.items()}
    return found
