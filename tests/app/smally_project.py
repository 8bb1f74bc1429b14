"""A project whose robot is the user's own: a URDF, a MoveIt configuration package, `grip.yaml` and a task."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

PROJECT = """grip: 1
robot:
  moveit: src/smally_moveit_config
  grasp_frames:
    manipulator: {link: palm, xyz: [0, 0, 0.09]}
arms: {right: {group: manipulator, hand: gripper}}
hands: {gripper: {group: gripper}}
world: table
"""
TASK = """grip: 1
name: wave

root:
  kind: sequence
  children:
    home: {node: arm/move_to, with: {state: home}}
    up: {node: arm/move_straight, with: {offset: [0.0, 0.0, 0.05]}}
    close: {node: hand/posture, with: {posture: closed}}
    open: {node: hand/open}
"""


def robot_files():
    """Return the writer of the robot's files, which the commanders' tests own."""
    if "robot_files" not in sys.modules:
        path = Path(__file__).parents[1] / "commanders" / "robot_files.py"
        spec = importlib.util.spec_from_file_location("robot_files", path)
        sys.modules["robot_files"] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules["robot_files"])
    return sys.modules["robot_files"]


def write_project(folder: Path) -> Path:
    """Write the project; return its task's file."""
    files = robot_files()
    files.description_package(folder / "src")
    files.moveit_package(folder / "src", 2)
    (folder / "grip.yaml").write_text(PROJECT)
    (folder / "wave.yaml").write_text(TASK)
    return folder / "wave.yaml"
