"""`grip run --robot fake` runs tasks of components, sensors on topics, frames and topics without any of them."""

from __future__ import annotations

import subprocess
import sys
import textwrap

import pytest

from grip_bt.app.runs.execute import run
from grip_bt.app.wiring.fake import value_of
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import SensorError
from grip_bt.base.ports import Ros, Sensor
from grip_bt.base.types import BUILTINS, VALUES
from grip_bt.base.values import Pose
from grip_bt.commanders.fake import FakeRos, FakeSensor
from grip_bt.runtime import JournalReader

PROJECT = """
grip: 1
arms: {right: {}}
message_server: true
sensors:
  cam:
    topics:
      image: {topic: /cam/colour, type: Image}
      cloud: {topic: /cam/points, type: PointCloud}
    mount: {frame: cam_optical, position: [0, 0, 1.5]}
    driver: {command: [/no/such/driver]}
"""
TASK = """
grip: 1
name: look
data: {image: Image, cloud: PointCloud, pose: Pose, speed: Any, heard: Any}
root:
  kind: sequence
  children:
    see: {node: sensor/cam, out: {image: image, cloud: cloud}}
    where: {node: ros/lookup_transform, in: {at: image}, with: {target: world, source: cam_optical}, out: {pose: pose}}
    keep: {node: messages/put, in: {value: pose}, with: {store: poses, name: seen}}
    say: {node: ros/publish, in: {value: pose}, with: {topic: /seen, type: geometry_msgs/msg/PoseStamped}}
    hear: {node: ros/wait_for_message, with: {topic: /seen, type: geometry_msgs/msg/PoseStamped}, out: {message: heard}}
    ask: {node: ros/get_parameter, with: {node: /driver, name: speed}, out: {value: speed}}
"""


@pytest.fixture
def project(tmp_path):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "look.yaml").write_text(TASK)
    return tmp_path


def test_sensors_topics_frames_parameters_and_messages_run_without_ros(project):
    journal = project / "j.sqlite"
    result = run(project / "look.yaml", robot="fake", journal=journal)
    assert result.outcome == "success", result
    with JournalReader(journal) as reader:
        written = {n: reader.value(e) for n, e in reader.variables(reader.runs()[0].id).items()}
    assert written["pose"].position[2] == 1.5  # the mount's
    assert written["heard"] == written["pose"]
    assert len(written["cloud"].points) > 0


def test_it_loads_no_rclpy(project):
    code = textwrap.dedent("""
        import sys
        from grip_bt.app.runs.execute import run
        assert run("look.yaml", robot="fake").outcome == "success"
        assert "rclpy" not in sys.modules
    """)
    subprocess.run([sys.executable, "-c", code], cwd=project, check=True, timeout=600)


def test_what_a_sensor_gives_is_said_from_the_command_line(project):
    command = [sys.executable, "-m", "grip_bt.cli", "run", "look.yaml", "--robot", "fake"]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    mocked = [*command, "--mock", "see=failure.no_data"]
    done = subprocess.run(mocked, cwd=project, capture_output=True, text=True, timeout=600)
    assert done.returncode == 3, done.stderr
    assert "no_data" in done.stdout + done.stderr


@pytest.mark.parametrize("name", [*VALUES, *BUILTINS])
def test_every_declared_type_has_a_fake(name):
    assert type(value_of(name)).__name__ == name


def test_lists_dictionaries_and_what_may_be_missing():
    assert [type(g).__name__ for g in value_of("list[Grasp]")] == ["Grasp"]
    assert (value_of("list[float]"), value_of("dict[str, Pose]")) == ([], {})
    assert value_of("Pose | None") is None
    assert value_of("Any") is None


def test_a_message_whose_package_is_not_there_is_named():
    with pytest.raises(SensorError, match="there is no fake of nowhere_msgs/msg/Thing.*--mock NODE=SCRIPT"):
        value_of("nowhere_msgs/msg/Thing")


def test_fakes_are_what_the_ports_ask_for():
    def nowhere(target, source):
        raise SensorError("there is no such frame")

    def make(name):
        raise SensorError(f"no {name}")

    ros = FakeRos(make, nowhere)
    assert isinstance(ros, Ros)
    assert isinstance(FakeSensor(), Sensor)
    for operation in (
        ros.next("/x", "a/msg/B", "Any", 1.0),
        ros.together({"/x": "a/msg/B"}, 0.1, 1.0),
        ros.transform("a", "b", 1.0),
        FakeSensor().capture(),
        FakeSensor([SensorError("dark")]).capture(),
    ):
        with pytest.raises(SensorError):
            operation.result()
    ros.set_parameter("/n", "p", 3, 1.0)
    assert ros.get_parameter("/n", "p", 1.0).result() == 3
    ros.publish("/x", "a/msg/B", Pose(), 1, 1.0)
    assert ros.recent("/x", "a/msg/B", "Pose", 1.0, 1.0).result() == Pose()
    assert ros.together({"/x": "a/msg/B"}, 0.1, 1.0).result() == {"/x": Pose()}


def test_a_component_that_is_not_in_the_project_is_still_named(project):
    from grip_bt.app.project.folder import find_project
    from grip_bt.app.wiring.fake import fake_components

    with pytest.raises(UnknownNameError, match="component 'grasps'"):
        fake_components(find_project(project), ["grasps"])
