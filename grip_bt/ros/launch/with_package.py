"""Runs a launch file by ROS's own `launch` package, where that is importable but `ros2` isn't on the path.

python -m grip_bt.ros.launch.with_package FILE NAME:=VALUE ...
"""

from __future__ import annotations

import sys


def main(words: list[str]) -> int:
    """Run a file until it ends; return `launch`'s exit status."""
    from launch import LaunchDescription, LaunchService
    from launch.actions import IncludeLaunchDescription
    from launch.launch_description_sources import AnyLaunchDescriptionSource

    file, *rest = words
    arguments = [tuple(word.split(":=", 1)) for word in rest]
    service = LaunchService(argv=rest)
    include = IncludeLaunchDescription(AnyLaunchDescriptionSource(file), launch_arguments=arguments)
    service.include_launch_description(LaunchDescription([include]))
    return int(service.run())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
