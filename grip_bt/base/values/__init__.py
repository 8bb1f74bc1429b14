"""Values that travel between nodes: frozen, with read-only arrays, units and frames stated."""

from .constraint import PathConstraint
from .grasp import Failure, Grasp
from .joints import JointState, Plan, Trajectory
from .perception import CameraInfo, DepthImage, Image, PointCloud, RgbdFrame
from .pose import Pose
from .way_point import WayPoint

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
