"""Captures of sensors on topics: what belongs to one moment, which moments count, and what a driver's end does."""

from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest
from patience import PATIENCE
from ros_bench import Deadline, ended

from grip_bt.base.failures import SensorError, ServerTimeOutError
from grip_bt.ros.interface import RosInterface
from grip_bt.ros.sensing import open_sensors
from grip_bt.task.catalog.ros_config import SensorConfig

pytestmark = pytest.mark.ros
NOW = 1000.0
"""The time of the clock that stamps messages; it stands still."""
IMAGE, NUMBER = "sensor_msgs/msg/Image", "std_msgs/msg/Float64"


@pytest.fixture
def ros(bus):
    return RosInterface(bus, now=lambda: NOW)


def send(ros, topic, message, **fields):
    """Publish once somebody listens."""
    sent = ros.bus.writer(message, topic).publish(made(message, **fields), subscribers=1, timeout=PATIENCE)
    ended(sent)


def made(message, stamp=None, **fields):
    from grip_bt.ros.client.types import load_type

    whole = load_type(message)(**fields)
    if stamp is not None:
        whole.header.stamp.sec, whole.header.stamp.nanosec = int(stamp), round(stamp % 1 * 1e9)
    return whole


@pytest.mark.parametrize("stamp", [NOW + 0.02, 0.0], ids=["stamped", "never stamped"])
def test_a_message_without_a_stamp_counts_as_taken_when_it_came(ros, stamp):
    both = ros.together({"/image": IMAGE, "/force": NUMBER}, 0.05, 600.0)
    send(ros, "/image", IMAGE, stamp=stamp, height=3)
    send(ros, "/force", NUMBER, data=1.5)
    found = ended(both)
    assert (found["/image"].height, found["/force"].data) == (3, 1.5)


def test_what_was_taken_before_the_capture_is_passed_over(ros):
    one = ros.together({"/image": IMAGE}, 0.05, 600.0)
    send(ros, "/image", IMAGE, stamp=NOW - 0.1, height=1)
    send(ros, "/image", IMAGE, stamp=NOW + 0.1, height=2)
    assert ended(one)["/image"].height == 2


def test_a_stamp_of_another_clock_says_nothing_of_before(ros):
    one = ros.together({"/image": IMAGE}, 0.05, 600.0)
    send(ros, "/image", IMAGE, stamp=12.5, height=1)
    assert ended(one)["/image"].height == 1


def test_a_capture_in_vain_says_that_all_came_too_early(ros, monkeypatch):
    monkeypatch.setattr("grip_bt.ros.interface.threading", SimpleNamespace(Timer=Deadline))
    one, heard = ros.together({"/image": IMAGE}, 0.05, 4.0), threading.Event()
    ros.bus.reader(IMAGE, "/image").listen(lambda _: heard.set())  # after the capture, which is called first
    send(ros, "/image", IMAGE, stamp=NOW - 0.25)
    assert heard.wait(PATIENCE)
    Deadline.last.over()
    with pytest.raises(ServerTimeOutError, match=r"what came was taken before it was asked for, the last 0\.25 s"):
        ended(one)


def test_a_driver_that_dies_ends_the_capture_under_way_with_its_last_words(ros, tmp_path):
    waits = "until [ -e go ]; do sleep 0.05; done; echo no camera found; exit 3"
    config = {"topics": {"x": {"topic": "/x", "type": "Image"}}, "timeout": 1000, "driver": {"command": ["sh", "-c"]}}
    config["driver"]["command"].append(waits)
    sensor = open_sensors({"cam": SensorConfig.model_validate(config)}, ros, tmp_path)["cam"]
    capture = sensor.capture()
    assert not capture.done()
    (tmp_path / "go").touch()
    with pytest.raises(SensorError, match=r"sensor cam: .*ended with status 3; its last output .*\nno camera found"):
        ended(capture)
    with pytest.raises(SensorError, match="no camera found"):
        ended(sensor.capture())
