"""Whether services and topics are there, asked of the running graph; connected only when somebody asks."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from grip_bt.task.catalog.component_parts import Ready

if TYPE_CHECKING:
    from ..bus import Bus

FRESH = 0.25
"""How long one look at the graph holds [s]."""


class GraphWatch:
    """Looks at the graph of one DDS domain.

    Args:
        domain_id: the domain; ROS_DOMAIN_ID, else 0, by default.
    """

    def __init__(self, domain_id: int | None = None):
        self._domain = domain_id
        self._bus: Bus | None = None
        self._looked = float("-inf")
        self._services: set[str] = set()
        self._topics: set[str] = set()

    def sees(self, ready: Ready) -> bool:
        """Tell whether a service or topic has somebody who serves it."""
        if time.monotonic() - self._looked > FRESH:
            self._look()
        return ready.service in self._services if ready.service else ready.topic in self._topics

    def instead(self, ready: Ready) -> str:
        """Return which services or topics there are instead of one that didn't come, as the end of a sentence."""
        bus = self._bus
        if ready.log is not None or bus is None:
            return ""
        from ..others import other_servers, other_topics

        def look() -> str:
            if ready.service is not None:
                return other_servers(bus.node, ready.service)
            return other_topics(bus.node, str(ready.topic), "")

        operation = bus.post(look)
        return operation.result() if operation.wait(2.0) else ""

    def close(self) -> None:
        """Leave the graph; harmless when repeated."""
        if self._bus is not None:
            self._bus.close()

    def _look(self) -> None:
        if self._bus is None:
            from ..bus import Bus

            self._bus = Bus("grip_launch", domain_id=self._domain)
        node = self._bus.node

        def look() -> tuple[set[str], set[str]]:
            from rclpy.action.graph import get_action_names_and_types

            services = {name for name, _ in node.get_service_names_and_types()}
            services |= {name for name, _ in get_action_names_and_types(node)}
            topics = {name for name, _ in node.get_topic_names_and_types() if node.count_publishers(name)}
            return services, topics

        operation = self._bus.post(look)
        if operation.wait(2.0):
            self._services, self._topics = operation.result()
            self._looked = time.monotonic()
