"""Signatures of ROS 1 and of ROS 2: there a node comes first, here none; both are taken."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any


def is_node(thing: Any) -> bool:
    """Tell whether something is a node, of rclpy or a stand-in."""
    return hasattr(thing, "create_publisher") and hasattr(thing, "get_name")


def with_optional_node(init: Callable[..., None]) -> Callable[..., None]:
    """Let an `__init__` be called with a node first, or as `node=`; it is kept as `_node`."""

    @functools.wraps(init)
    def taking(self: Any, *args: Any, **kwargs: Any) -> None:
        node = kwargs.pop("node", None)
        if args and is_node(args[0]):
            node, *args = args  # type: ignore[assignment]
        self._node = node
        init(self, *args, **kwargs)

    return taking
