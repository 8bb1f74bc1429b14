"""MoveIt configuration packages, as MoveIt's setup assistants write them for ROS 1 and ROS 2."""

from .package import MoveItPackage, is_moveit_package, read_package
from .settings import Controller, JointLimits, PlannerChoice, Sensor

__all__ = [
    "Controller",
    "JointLimits",
    "MoveItPackage",
    "PlannerChoice",
    "Sensor",
    "is_moveit_package",
    "read_package",
]
