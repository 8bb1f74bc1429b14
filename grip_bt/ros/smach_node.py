"""`SmachNode` of smach_ros's ROS 2 branch: a node that spins in a thread of its own."""

from __future__ import annotations

import threading
from typing import Any

from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


class SmachNode(Node):
    """A node of the user's, for the user's own publishers, timers and so on; states don't need it.

    Args:
        node_name: its name.
        **kwargs: see `rclpy.node.Node`.
    """

    def __init__(self, node_name: str, **kwargs: Any):
        super().__init__(node_name, **kwargs)
        self._spinner: threading.Thread | None = None

    def start(self) -> None:
        """Spin in a thread until ROS is shut down."""
        self._spinner = threading.Thread(target=self._spin, name=f"smach-{self.get_name()}", daemon=True)
        self._spinner.start()

    def _spin(self) -> None:
        executor = SingleThreadedExecutor(context=self.context)
        executor.add_node(self)
        try:
            while self.context.ok():
                executor.spin_once(timeout_sec=0.5)
        except ExternalShutdownException:
            pass
        finally:
            executor.shutdown()

    def join(self) -> None:
        """Wait until it has stopped spinning."""
        if self._spinner is not None:
            self._spinner.join()
