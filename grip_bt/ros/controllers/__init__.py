"""Joints of real robots: controllers of ros2_control, and whatever speaks like them, behind the commanders' ports."""

from .gripper import GripperHand
from .hand import ControlledHand
from .joint_states import JointStates
from .motion import RosExecutor
from .streaming import StreamedExecutor
from .switching import ControllerManager
from .trajectory import TrajectoryExecutor
from .trajectory_topic import TopicExecutor

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
