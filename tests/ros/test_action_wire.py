"""The status of a goal, found in a serialized list, is the one that rclpy reads there."""

from __future__ import annotations

import uuid

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import grip_bt.ros  # noqa: F401 - before any message package
from grip_bt.ros.action_wire import new_goal_id, status_in

from action_msgs.msg import GoalStatus, GoalStatusArray  # isort: skip
from rclpy.serialization import serialize_message  # isort: skip

IDS = st.lists(st.binary(min_size=16, max_size=16), max_size=12, unique=True)


def listed(ids, statuses, stamps):
    message = GoalStatusArray()
    for goal_id, status, (seconds, nanoseconds) in zip(ids, statuses, stamps, strict=False):
        entry = GoalStatus(status=status)
        entry.goal_info.goal_id.uuid = list(goal_id)
        entry.goal_info.stamp.sec, entry.goal_info.stamp.nanosec = seconds, nanoseconds
        message.status_list.append(entry)
    return serialize_message(message)


STATUSES = st.lists(st.integers(0, 6), min_size=12, max_size=12)
STAMPS = st.lists(
    st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1)), min_size=12, max_size=12
)  # any bytes, also such as look like a part of an id


@pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")  # of a parser that rclpy loads
@settings(deadline=None)
@given(IDS, STATUSES, STAMPS, st.binary(min_size=16, max_size=16))
@example([bytes(16), bytes([0] * 15 + [1])], [3] * 12, [(0, 0)] * 12, bytes([0] * 14 + [1, 0]))
@example([bytes([1] * 16), bytes(16)], [0] * 12, [(0, 0)] * 12, bytes([2] * 16))
def test_every_goal_is_found_with_its_status_and_no_other_is(ids, statuses, stamps, stranger):
    message = listed(ids, statuses, stamps)
    found = [status_in(message, goal_id) for goal_id in ids]
    assert found == statuses[: len(ids)]
    if stranger not in ids:
        assert status_in(message, stranger) == 0


def test_ids_are_new_each_time():
    ids = {new_goal_id() for _ in range(1000)}
    assert len(ids) == 1000
    assert {uuid.UUID(bytes=i).version for i in ids} == {4}
