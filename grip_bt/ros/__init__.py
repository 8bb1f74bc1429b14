"""ROS 2: the only room that imports rclpy and message packages. Importing it loads neither."""

from .environment import RosEnvironment, environment, prepare

prepare()

__all__ = ["RosEnvironment", "environment", "prepare"]
