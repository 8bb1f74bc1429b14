"""MoveIt 2's move_group behind the commanders' ports: it plans, it chooses grasps, it executes."""

from .client import MoveGroup, MoveGroupExecutor
from .goals import ArmMapping
from .planner import MoveGroupPlanner

__all__ = ["ArmMapping", "MoveGroup", "MoveGroupExecutor", "MoveGroupPlanner"]
