"""Which extra of the installation brings a package: what a command says where one is missing."""

from __future__ import annotations

from grip_bt.base.errors import MissingPartError

_PACKAGES = {
    "motion": ("coal", "example_robot_data", "ompl", "pinocchio", "pytracik", "toppra", "xacro"),
    "sim": ("sapien",),
    "ros": ("ament_index_python", "builtin_interfaces", "rclpy", "rosidl_adapter", "rosidl_parser", "std_msgs"),
    "gui": ("fastapi", "starlette", "uvicorn", "websockets"),
    "recording": ("mcap",),
    "analytic": ("eaik",),
}
EXTRAS = {package: extra for extra, packages in _PACKAGES.items() for package in packages}


def missing_extra(error: ModuleNotFoundError) -> MissingPartError | None:
    """Return in our words that a package of an extra isn't installed; None for any other module."""
    package = (error.name or "").partition(".")[0]
    extra = EXTRAS.get(package)
    return None if extra is None else MissingPartError(f"{package!r}", f"pip install 'grip-bt[{extra}]'")
