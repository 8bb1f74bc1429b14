"""`RosState`: a state with a node, as the ROS 2 branch has it; in ROS 1's style it has none."""

from __future__ import annotations

from typing import Any

from grip_bt.smach_compat.state import State

from ._connection import ros, with_optional_node

__all__ = ["RosState"]


class RosState(State):
    """A state that may have an rclpy node, first or by name; none in ROS 1's style."""

    @with_optional_node
    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)

    @property
    def node(self) -> Any:
        return self._node  # type: ignore[attr-defined]

    def _full_name(self, name: str) -> str:
        """Return a name as the node would resolve it."""
        return ros().name_of(name, self.node)
