"""Values that travel between nodes: frozen, with read-only arrays, units and frames stated."""

from .grasp import Failure, Grasp
from .joints import JointState, Plan, Trajectory
from .perception import CameraInfo, DepthImage, Image, PointCloud, RgbdFrame
from .pose import Pose
from .solids import Box, CellMap, Cylinder, Mesh, Solid, Sphere

__all__ = [
    "Box",
    "CameraInfo",
    "CellMap",
    "Cylinder",
    "DepthImage",
    "Failure",
    "Grasp",
    "Image",
    "JointState",
    "Mesh",
    "Plan",
    "PointCloud",
    "Pose",
    "RgbdFrame",
    "Solid",
    "Sphere",
    "Trajectory",
]
