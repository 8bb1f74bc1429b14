"""The message managers over ROS 2: stores of named messages of any type, for every process and language.

with Bus() as bus:
    messages = RosMessages(bus)
    messages.put("poses", "bin", Pose([0.5, 0, 0.1])).wait(5)
"""

from __future__ import annotations

from .service import MessageServer, RosMessages

__all__ = ["MessageServer", "RosMessages"]
