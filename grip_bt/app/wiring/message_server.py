"""The named messages of a server that runs, in the user's own domain. Needs ROS."""

from __future__ import annotations

from contextlib import ExitStack

from grip_bt.ros.client.bus import Bus
from grip_bt.ros.messages.client import RosMessages


def connect(stack: ExitStack) -> RosMessages:
    """Connect to the server; `stack` closes the connection."""
    return RosMessages(stack.enter_context(Bus("grip_task_messages")))
