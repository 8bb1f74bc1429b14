"""`grip messages` as somebody types it, against a server."""

from __future__ import annotations

import json
import threading
import time
from functools import partial

import pytest
from patience import PATIENCE

from grip_bt.cli.__main__ import main
from grip_gui.live.inspector import RosInspector

pytestmark = [pytest.mark.ros, pytest.mark.slow]  # the first one builds the interfaces
FILES = {
    "joint_states.yaml": "home: {b: 0.1234567890123456, a: 2}\naway: {a: 1, b: 0}\n",
    "poses.yaml": "bin: {reference_frame: world, position: {x: 0.1, y: 0, z: 0}, orientation: {r: 0, p: 0, y: 0.3}}\n",
}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    """Give the domain of a server with a few messages."""
    from grip_bt.ros.client.bus import Bus
    from grip_bt.ros.environment import free_domain
    from grip_bt.ros.messages import MessageServer

    folder = tmp_path_factory.mktemp("project")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    with free_domain() as domain, Bus("server", domain_id=domain) as bus:
        MessageServer(bus, folder, folder / "kept.sqlite")
        yield domain


@pytest.fixture
def ask(served, monkeypatch, capsys):
    """Return a function that runs the verb and returns its status, output and errors."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(served))
    from grip_bt.ros import messages as managers

    patient = partial(managers.RosMessages, timeout=PATIENCE, wait=PATIENCE)
    monkeypatch.setattr("grip_bt.cli.messages.RosMessages", patient)
    monkeypatch.setattr("grip_bt.cli.messages.WAIT", PATIENCE)

    def run(*words: str) -> tuple[int, str, str]:
        status = main(["messages", *words])
        return status, *capsys.readouterr()

    return run


def test_what_is_shown_can_be_added_and_is_the_same_to_the_last_digit(ask):
    for store, name in (("joint_states", "home"), ("poses", "bin")):
        shown = ask("show", store, name)
        assert shown[0] == 0
        assert ask("add", store, "copy", shown[1])[0] == 0
        assert ask("show", store, "copy")[1] == shown[1]
    assert "0.1234567890123456" in ask("show", "joint_states", "copy")[1]


def test_a_trajectory_that_names_the_servers_states_is_put_from_the_page_too(ask):
    looker = RosInspector()
    try:
        looker.put("trajectories", "from_page", "", "[{name: home, interpolate_time: 0, pause_time: 1}]")
    finally:
        looker.close()
    assert ask("show", "trajectories", "from_page")[0] == 0


def test_another_program_reads_and_writes_a_message_as_text(ask, served):
    import yaml

    from grip_bt.ros.client.bus import Bus
    from grip_bt.ros.client.types import load_type

    entry = load_type("grip_msgs/msg/Entry")
    pose = "{reference_frame: table, position: {x: 1, y: 0, z: 0}, orientation: {r: 0, p: 0, y: 0}}"
    with Bus("somebody", domain_id=served) as bus:

        def call(service: str, type_: str, **fields: object):
            operation = bus.call(f"grip_msgs/srv/{type_}", f"/grip/messages/{service}", PATIENCE, PATIENCE, **fields)
            assert operation.wait(PATIENCE)
            return operation.result()

        assert call("add", "AddMessage", entry=entry(store="poses", name="there", text=pose)).success
        got = call("get", "GetMessage", store="poses", name="there").entry
        assert yaml.safe_load(got.text)["position"] == {"x": 1.0, "y": 0.0, "z": 0.0}
        assert call("add", "AddMessage", entry=entry(store="poses", name="again", text=got.text)).success
        assert call("get", "GetMessage", store="poses", name="again").entry.text == got.text
        wrong = call("add", "AddMessage", entry=entry(store="poses", name="there", text="{position: 1}"))
        assert not wrong.success
        assert "reference_frame" in wrong.message
        words = entry(store="said", type="std_msgs/msg/String", text="data: hello")
        assert call("add", "AddMessage", entry=words).success
        assert call("get", "GetMessage", store="said", name="").entry.text == "data: hello\n"


def test_a_trajectory_is_added_by_the_names_of_joint_states(ask):
    points = "[{name: home, interpolate_time: 0, pause_time: 0}, {name: away, interpolate_time: 2, pause_time: 0}]"
    assert ask("add", "trajectories", "leave", points)[0] == 0
    shown = json.loads(ask("show", "trajectories", "leave", "--json")[1])
    assert shown["type"] == "trajectory_msgs/msg/JointTrajectory"
    assert shown["message"]["joint_names"] == ["a", "b"]
    assert [point["positions"] for point in shown["message"]["points"]] == [[2.0, 0.1234567890123456], [1.0, 0.0]]
    whole = ask("show", "trajectories", "leave")[1]
    assert ask("add", "trajectories", "again", whole)[0] == 0
    assert ask("show", "trajectories", "again")[1] == whole


def test_robot_poses_are_as_in_files(ask):
    text = "reference_frame: palm\nthumb: {position: {x: 0, y: 0, z: 1}, orientation: {r: 0, p: 0, y: 0}}\n"
    assert ask("add", "robot_poses", "pinch", text)[0] == 0
    assert "reference_frame: palm\nthumb:\n" in ask("show", "robot_poses", "pinch")[1]


def test_any_message_is_queued_and_taken_in_order(ask, tmp_path, monkeypatch):
    (tmp_path / "two.yaml").write_text("data: two")
    assert ask("push", "words", "{data: one}", "--type", "std_msgs/msg/String", "--by", "me")[0] == 0
    assert ask("push", "words", "--file", str(tmp_path / "two.yaml"))[0] == 0
    assert "words          2 in the queue" in ask("list", "words")[1]
    assert json.loads(ask("take", "words", "--json")[1])["provenance"] == "me"
    assert ask("take", "words")[1] == "data: two\n"
    assert ask("push", "words", "{datum: x}")[0] != 0
    assert ask("push", "words", "{data: three}")[0] == 0
    assert ask("take", "words")[1] == "data: three\n"
    status, _, error = ask("take", "words")
    assert status != 0
    assert "its queue is empty" in error


def test_the_next_message_of_a_topic_is_added_with_its_header(ask, served):
    from grip_bt.ros.client.bus import Bus
    from grip_bt.ros.client.types import load_type

    over = threading.Event()
    pose = load_type("geometry_msgs/msg/PoseStamped")()
    pose.header.frame_id, pose.header.stamp.sec = "table", 17
    with Bus("somebody", domain_id=served) as bus:
        writer = bus.writer("geometry_msgs/msg/PoseStamped", "/seen")

        def publish() -> None:
            while not over.wait(0.1):
                writer.publish(pose).wait(1)

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            assert ask("add", "poses", "seen", "--topic", "/seen", "--within", "400")[0] == 0
        finally:
            over.set()
            thread.join()
    header = json.loads(ask("show", "poses", "seen", "--json")[1])["message"]["header"]
    assert (header["frame_id"], header["stamp"]["sec"]) == ("table", 17)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("add", "poses", "x"), "the value is missing: say YAML, `-` .the standard input., `--file FILE`"),
        (("add", "poses", "x", "{}", "--topic", "/t"), "one way only"),
        (("add", "poses", "x", "{reference_frame: w, position: {x: 1}}"), "value:1:1: the key 'orientation'"),
        (("add", "poses", "x", "--file", "/nowhere/x.yaml"), "/nowhere/x.yaml"),
        (("add", "poses", "x", "--topic", "/nobody", "--within", "0.2"), "it has no publisher"),
        (("add", "thoughts", "x", "{data: 1}"), "store 'thoughts' is new: say the ROS type"),
        (("add", "thoughts", "x", "{data: 1}", "--type", "std_msgs/msg/Sting"), "did you mean 'std_msgs/msg/String'"),
        (("add", "thoughts", "x", "{dat: 1}", "--type", "std_msgs/msg/String"), "no such field; did you mean 'data'"),
        (("add", "trajectories", "x", "[{name: hom, interpolate_time: 0, pause_time: 0}]"), "did you mean 'home'"),
        (("show", "poses", "bim"), "unknown entry 'bim'; did you mean 'bin'"),
        (("list", "pose"), "unknown store 'pose'"),
        (("watch", "pose"), "unknown store 'pose'"),
        (("delete", "poses", "nothing"), "unknown entry 'nothing'"),
        (("reset", "nothing"), "unknown store 'nothing'"),
    ],
)
def test_what_cannot_be_done_is_told(ask, words, told):
    import re

    status, _, error = ask(*words)
    assert status != 0
    assert re.search(told, error), error
    assert "Traceback" not in error


def test_changes_are_printed_as_they_come(ask, served, capsys):
    from grip_bt.base.values import Pose
    from grip_bt.ros.client.bus import Bus
    from grip_bt.ros.messages import RosMessages

    over = threading.Event()
    with Bus("somebody", domain_id=served) as bus:
        messages = RosMessages(bus, wait=PATIENCE, timeout=PATIENCE)

        def change() -> None:
            while not over.is_set():
                messages.put("poses", "moved", Pose((0.5, 0, 0))).wait(PATIENCE)
                time.sleep(0.1)

        thread = threading.Thread(target=change)
        thread.start()
        try:
            status, printed, _ = ask("watch", "poses", "--count", "2", "--json")
        finally:
            over.set()
            thread.join()
    assert status == 0
    first, _second = map(json.loads, printed.splitlines())
    assert (first["store"], first["change"], first["name"]) == ("poses", "put", "moved")
    assert first["message"]["pose"]["position"]["x"] == 0.5
