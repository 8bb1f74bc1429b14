"""ROS 2 launch files without ROS's own tools: XML and YAML files read, resolved to processes, run and watched over."""

from .element import LaunchError, read_elements
from .interpreter import read_launch_file

__all__ = ["LaunchError", "read_elements", "read_launch_file"]
