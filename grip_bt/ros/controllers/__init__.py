"""Joints of real robots: controllers of ros2_control, and whatever speaks like them, behind the commanders' ports."""

from .hands import ControlledHand, GripperHand
from .joint_states import JointStates
from .motion import RosExecutor
from .streaming import StreamedExecutor, TopicExecutor
from .switching import ControllerManager
from .trajectory import TrajectoryExecutor

__all__ = [
    "ControlledHand",
    "ControllerManager",
    "GripperHand",
    "JointStates",
    "RosExecutor",
    "StreamedExecutor",
    "TopicExecutor",
    "TrajectoryExecutor",
]
