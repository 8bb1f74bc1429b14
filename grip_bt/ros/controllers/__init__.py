"""Joints of real robots: controllers of ros2_control, and whatever speaks like them, behind the commanders' ports."""

from grip_bt.ros.controllers.trajectory import ControllerManager

from .hands import ControlledHand, GripperHand, TopicTouch, TopicWrench
from .joint_states import JointStates
from .streaming import StreamedExecutor, TopicExecutor
from .trajectory import TrajectoryExecutor

__all__ = [
    "ControlledHand",
    "ControllerManager",
    "GripperHand",
    "JointStates",
    "StreamedExecutor",
    "TopicExecutor",
    "TopicTouch",
    "TopicWrench",
    "TrajectoryExecutor",
]
