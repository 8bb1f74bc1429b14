"""Values that travel between nodes: frozen, with read-only arrays, units and frames stated."""

from .goals import Failure, Grasp, PathConstraint, WayPoint
from .joints import JointState, Plan, Trajectory
from .perception import CameraInfo, DepthImage, Image, PointCloud, RgbdFrame
from .pose import Pose

__all__ = [
    "CameraInfo",
    "DepthImage",
    "Failure",
    "Grasp",
    "Image",
    "JointState",
    "PathConstraint",
    "Plan",
    "PointCloud",
    "Pose",
    "RgbdFrame",
    "Trajectory",
    "WayPoint",
]
