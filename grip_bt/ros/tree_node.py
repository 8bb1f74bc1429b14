"""A ROS node for somebody's own tree: spun beside the ticks, and never during one, as in a program of theirs."""

from __future__ import annotations

import threading
from types import TracebackType

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import ok

_WAIT = 0.1
"""How long [s] a callback is waited for before it is looked whether the node is to be closed."""


class TreeNode:
    """A node in rclpy's own context, which is opened where nobody has.

    Entered by whoever keeps its callbacks out for a while.
    """

    def __init__(self, name: str = "grip_tree"):
        self._own = not ok()
        if self._own:
            rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self.node: Node = rclpy.create_node(name)
        self._lock, self._closing = threading.RLock(), threading.Event()
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name="grip_tree_node", daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            while not self._closing.is_set():
                try:
                    handler, _, _ = self._executor.wait_for_ready_callbacks(timeout_sec=_WAIT)
                except TimeoutException:
                    continue
                with self._lock:
                    handler()
        except ExternalShutdownException:
            pass
        except Exception as error:  # noqa: BLE001 - somebody's callback may do anything
            if not self._closing.is_set():
                self.node.get_logger().error(f"a callback raised {type(error).__name__}: {error}")

    def close(self) -> None:
        """Spin no more, and close what was opened."""
        self._closing.set()
        self._executor.wake()
        self._thread.join(5 * _WAIT)
        self.node.destroy_node()
        if self._own and ok():
            rclpy.shutdown()

    def __enter__(self) -> TreeNode:
        self._lock.acquire()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._lock.release()
