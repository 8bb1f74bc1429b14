"""Named messages over ROS 2: exact, typed, told of, kept; a server in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE, until
from ros_bench import ended

from grip_bt.base.failures import BadReplyError, EmptyQueueError, NoEntryError, ServerLostError
from grip_bt.base.values import Grasp, Image, JointState, Plan, PointCloud, Pose, Trajectory

pytestmark = [pytest.mark.ros, pytest.mark.slow]  # the first one builds the interfaces
POSES = """
bin: {reference_frame: world, position: {x: 0.1234567890123456, y: 1.0e-17, z: 3}, orientation: {r: 0, p: 0, y: 0}}
pinch:
  reference_frame: palm
  thumb: {position: {x: 0, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 0, w: 1}}
"""


@pytest.fixture
def folder(tmp_path) -> Path:
    messages = tmp_path / "messages"
    messages.mkdir()
    (messages / "poses.yaml").write_text(POSES)
    return messages


@pytest.fixture
def messages(bus, folder, tmp_path):
    """Return a client of a server in this process, on another connection to ROS."""
    from patient_bus import PatientBus

    from grip_bt.ros.messages import MessageServer, RosMessages

    with PatientBus("server", domain_id=bus.node.context.get_domain_id()) as serving:
        MessageServer(serving, folder, tmp_path / "kept.sqlite")
        yield RosMessages(bus, timeout=PATIENCE, wait=PATIENCE)


def odd(shape=(), seed=0) -> np.ndarray:
    """Return numbers that single precision can't hold."""
    return np.random.default_rng(seed).normal(size=shape) + 1e-13


JOINTS = JointState(("b", "a"), odd(2), odd(2), odd(2), time=12.000000001)
POSE = Pose(odd(3), odd(4), "table")
TRAJECTORY = Trajectory(("a", "b"), np.array([0, 0.5, 1.25]), odd((3, 2)), odd((3, 2)))
VALUES = {
    "joint_states": JOINTS,
    "poses": POSE,
    "robot_poses": {"thumb": POSE, "index": Pose(odd(3, 2), frame="table")},
    "trajectories": TRAJECTORY,
    "plans": Plan("arm", TRAJECTORY, "RRTConnect", 0.1 + 0.2),
    "grasps": Grasp(POSE, POSE, POSE, posture=JOINTS, width=0.1 + 0.2, quality=1 / 3, provenance="me"),
    "clouds": PointCloud(odd((5, 3)).astype(np.float32), frame="camera", time=1.5),
    "images": Image(np.arange(24, dtype=np.uint8).reshape(2, 4, 3), "camera"),
}


@pytest.mark.parametrize("store", VALUES)
def test_every_kind_of_value_comes_back_to_the_last_bit(messages, store):
    ended(messages.put(store, "it", VALUES[store], "a test"))
    entry = ended(messages.get(store, "it"))
    assert entry.value == VALUES[store]
    assert (entry.name, entry.provenance) == ("it", "a test")
    assert abs(entry.time - time.time()) < 600


def test_a_message_of_any_type_is_kept_whole_with_its_header(messages):
    from geometry_msgs.msg import PoseStamped, WrenchStamped

    wrench = WrenchStamped()
    wrench.header.frame_id, wrench.header.stamp.sec, wrench.header.stamp.nanosec = "wrist", 17, 999_999_999
    wrench.wrench.force.x = 0.1 + 0.2
    ended(messages.put("wrenches", "touch", wrench))
    assert ended(messages.get("wrenches", "touch")).value == wrench
    pose = PoseStamped()
    pose.header.stamp.sec = 5
    with pytest.raises(BadReplyError, match="'wrenches' holds geometry_msgs/msg/WrenchStamped, not geometry_msgs"):
        ended(messages.put("wrenches", "pose", pose))
    assert ended(messages.names("wrenches")) == ("touch",)


def test_bytes_that_are_no_message_of_their_type_are_refused(messages):
    from grip_bt.ros.messages.wire import RawMessage

    for raw, reason in (
        (RawMessage("geometry_msgs/msg/PoseStamped", b"12345678"), "8 bytes aren't a geometry_msgs/msg/PoseStamped"),
        (RawMessage("geometry_msgs/msg/PoseStamped", b""), "0 bytes aren't"),
        (RawMessage("geometry_msgs/msg/Pos", b""), "did you mean"),
        (RawMessage("nothing_msgs/msg/X", b""), "the interface package 'nothing_msgs'"),
        (RawMessage("nonsense", b""), "unknown ROS type"),
    ):
        with pytest.raises(BadReplyError, match=reason):
            ended(messages.put("poses", "bad", raw))
    assert ended(messages.names("poses")) == ("bin",)


def test_a_value_that_no_message_can_hold_ends_the_request(messages):
    from grip_bt.ros.interface import BadRequestError

    sent = messages.put("poses", "it", "a text")
    assert sent.done()
    with pytest.raises(BadRequestError, match="store 'poses'"):
        sent.result()


def test_files_of_the_project_are_there_from_the_start_in_full_precision(messages, folder):
    entry = ended(messages.get("poses", "bin"))
    assert list(entry.value.position) == [0.1234567890123456, 1.0e-17, 3.0]
    assert entry.provenance == str(folder / "poses.yaml")
    assert ended(messages.get("robot_poses", "pinch")).value["thumb"].frame == "palm"


def test_a_queue_gives_first_what_came_first_and_each_once(messages):
    for i in range(4):
        ended(messages.put("poses", "", Pose([i, 0, 0])))
    assert [ended(messages.get("poses", "")).value.position[0] for _ in range(4)] == [0, 1, 2, 3]
    with pytest.raises(EmptyQueueError, match="its queue is empty"):
        ended(messages.get("poses", ""))


def test_what_is_not_there_is_named_with_what_is(messages):
    with pytest.raises(NoEntryError, match="unknown entry 'bim'; did you mean 'bin'"):
        ended(messages.get("poses", "bim"))
    with pytest.raises(NoEntryError, match="unknown store 'pose'"):
        ended(messages.names("pose"))
    with pytest.raises(NoEntryError):
        ended(messages.delete("poses", "nothing"))


def test_a_reset_forgets_what_was_added_and_reads_the_files_again(messages, folder):
    ended(messages.put("poses", "mine", Pose()))
    ended(messages.put("poses", "", Pose()))
    (folder / "poses.yaml").write_text(POSES.replace("bin:", "shelf:"))
    ended(messages.reset("poses"))
    assert ended(messages.names("poses")) == ("shelf",)
    with pytest.raises(EmptyQueueError):
        ended(messages.get("poses", ""))


def test_a_reset_with_a_broken_file_says_so_and_changes_nothing(messages, folder):
    ended(messages.put("poses", "mine", Pose()))
    (folder / "poses.yaml").write_text("bin: {reference_frame: world, position: {x: far}}")
    with pytest.raises(NoEntryError, match=r"poses.yaml:1:\d+: bin: the key 'orientation' is missing"):
        ended(messages.reset())
    assert "mine" in ended(messages.names("poses"))


def test_changes_are_told_in_order_with_their_values(messages):
    seen = []
    stop = messages.watch(lambda *change: seen.append(change))
    # Again and again, until the subscription is connected.
    until(lambda: seen or ended(messages.put("poses", "hello", Pose())))
    ended(messages.put("poses", "x", POSE))
    ended(messages.delete("poses", "x"))
    until(lambda: seen[-1][1] == "deleted", f"told: {seen}")
    assert [change[:3] for change in seen[-2:]] == [("poses", "put", "x"), ("poses", "deleted", "x")]
    assert seen[-2][3] == POSE
    stop()


def test_without_a_server_a_request_ends_and_says_so(bus):
    from grip_bt.ros.messages import RosMessages

    with pytest.raises(ServerLostError, match="/nobody/get"):
        ended(RosMessages(bus, "/nobody", wait=0.3).get("poses", "x"))


def test_the_command_serves_a_project_and_keeps_its_messages_over_restarts(bus, folder, domain):
    from grip_bt.ros.command import child_environment
    from grip_bt.ros.messages import RosMessages

    (folder.parent / "grip.yaml").write_text("grip: 1\n")
    command = [sys.executable, "-m", "grip_bt.cli", "messages"]
    env = child_environment((), domain)

    def serve() -> subprocess.Popen:
        return subprocess.Popen([*command, "serve", "--project", str(folder.parent)], env=env)

    messages = RosMessages(bus, timeout=PATIENCE, wait=PATIENCE)
    first = serve()
    try:
        ended(messages.put("poses", "mine", POSE, "me"), 2 * PATIENCE)
        ended(messages.put("poses", "", Pose([7, 0, 0])))
        shown = subprocess.run([*command, "list", "--json"], env=env, capture_output=True, text=True, check=True)
        rows = {(row["store"], row["name"]): row for row in json.loads(shown.stdout)}
        assert rows["poses", "mine"]["provenance"] == "me"
        assert ended(messages.save()) == 4
    finally:
        first.terminate()
        assert first.wait(PATIENCE) == 0
    second = serve()
    try:
        deadline = time.monotonic() + 2 * PATIENCE
        while True:
            try:
                entry = ended(messages.get("poses", "mine"), 2 * PATIENCE)
                break
            except ServerLostError:  # of the first one, which DDS still remembers
                assert time.monotonic() < deadline
        assert (entry.value, entry.provenance) == (POSE, "me")
        assert ended(messages.get("poses", "")).value.position[0] == 7
    finally:
        second.terminate()
        second.wait(PATIENCE)
