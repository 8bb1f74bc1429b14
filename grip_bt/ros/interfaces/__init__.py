"""Interface packages without a ROS installation: read by rosidl's parser, built with gcc and rosidl's generators."""

from grip_bt.ros.interfaces.packages import find_packages, read_package

from .build import Built, build_interfaces, content_hash, default_cache
from .definition import parse_interface, read_interface
from .generate import InterfaceBuildError

__all__ = [
    "Built",
    "InterfaceBuildError",
    "build_interfaces",
    "content_hash",
    "default_cache",
    "find_packages",
    "parse_interface",
    "read_interface",
    "read_package",
]
