"""Whoever an answer wakes runs before the executor goes on, which would keep the interpreter for another round."""

from __future__ import annotations

import threading

import pytest
from patience import PATIENCE
from ros_bench import ended

pytestmark = pytest.mark.ros
SET, WORK, TEXT = "std_srvs/srv/SetBool", "trial_interfaces/action/Work", "std_msgs/msg/String"


@pytest.fixture
def ways(monkeypatch):
    """Return a list that takes, each time that the executor stands aside, its thread and whether the owner was told."""
    found, operations = [], []

    def stand_aside():
        found.append((threading.current_thread().name.startswith("ros-"), operations[-1].done()))

    for module in ("client", "action", "topic"):
        monkeypatch.setattr(f"grip_bt.ros.{module}.give_way", stand_aside)
    return found, operations


def test_the_executor_stands_aside_when_the_owner_of_a_call_was_told(bus, serve, ways):
    found, operations = ways
    serve("std_srvs/SetBool", "/set")
    client = bus.service(SET, "/set")
    ended(client.wait_ready(PATIENCE))
    assert found == []
    operations.append(client.call(client.type.Request()))
    ended(operations[-1])
    ended(bus.post(lambda: None))  # behind the answer, on the bus's thread
    assert found == [(True, True)]


def test_it_stands_aside_for_results_of_goals(bus, start_server, trial, ways):
    found, operations = ways
    start_server("action_server.py", "/work", overlays=[trial])
    client = bus.action(WORK, "/work")
    operations.append(client.send(client.type.Goal(input="0", seconds=0.0)))
    ended(operations[-1])
    ended(bus.post(lambda: None))
    assert found == [(True, True)]


def test_it_stands_aside_for_messages_that_somebody_waits_for(bus, ways):
    found, operations = ways
    reader, writer = bus.reader(TEXT, "/words"), bus.writer(TEXT, "/words")
    operations.append(reader.next(PATIENCE))
    ended(writer.publish(reader.type(data="a"), subscribers=1))
    ended(operations[-1])
    ended(bus.post(lambda: None))
    assert found == [(True, True)]
