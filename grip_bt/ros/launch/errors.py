"""What can be wrong with a launch file."""

from __future__ import annotations

from grip_bt.base.errors import GripError


class LaunchError(GripError):
    """A launch file can't be run as it is.

    Attributes:
        source: the file.
        line: 1-based line, or None.
        reason: what is wrong, and what to do.
    """

    def __init__(self, source: str, line: int | None, reason: str):
        self.source, self.line, self.reason = source, line, reason
        super().__init__(f"{source}:{line}: {reason}" if line else f"{source}: {reason}")


class LegacyLaunchFileError(LaunchError):
    """A launch file is one of ROS 1; `changes` holds (line, what it says, what ROS 2 says)."""

    def __init__(self, source: str, changes: list[tuple[int, str, str]]):
        self.changes = changes
        listed = "".join(f"\n  line {line}: {old}: {new}" for line, old, new in changes)
        super().__init__(
            source, None, f"this is a ROS 1 launch file; to make it one of ROS 2 (.launch.xml), change:{listed}"
        )
