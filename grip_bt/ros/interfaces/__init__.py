"""Interface packages without a ROS installation: read by rosidl's parser, built with gcc and rosidl's generators."""

from .build import Built, build_interfaces, content_hash, default_cache
from .definition import parse_interface, read_interface
from .generate import InterfaceBuildError
from .package import Package, find_packages, read_package

__all__ = [
    "Built",
    "InterfaceBuildError",
    "Package",
    "build_interfaces",
    "content_hash",
    "default_cache",
    "find_packages",
    "parse_interface",
    "read_interface",
    "read_package",
]
