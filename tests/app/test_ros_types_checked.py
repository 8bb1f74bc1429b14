"""`grip check` tells which ROS types and programs a task needs and isn't given; nothing of ROS is started for it."""

from __future__ import annotations

import os
import sys

import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.task import read_text
from grip_bt.task.validation import validate

pytest.importorskip("rclpy")
COMPONENT = "name: c\ninterface: INTERFACE\nserver: /c\noutcomes: {done: 'true'}\n"
MANIFEST = "<package><name>my_msgs</name></package>"


@pytest.fixture
def project(tmp_path):
    """A project with a component that brings `my_msgs/srv/Do`."""
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    package = tmp_path / "components" / "c" / "interfaces" / "my_msgs"
    (package / "srv").mkdir(parents=True)
    (package / "srv" / "Do.srv").write_text("---\n")
    (package / "package.xml").write_text(MANIFEST)
    node = package.parents[1] / "node"
    node.mkdir()
    (node / "manifest.yaml").write_text("- {id: component/c, doc: d., implementation: 'leaf.py:C'}\n")
    return tmp_path


def said(project, root):
    task = read_text(f"grip: 1\nname: demo\nroot: {root}\n").task
    return [i.message for i in validate(task, project_catalog(project)).issues if i.code == "missing-package"]


def with_component(project, interface, start=""):
    file = project / "components" / "c" / "component.yaml"
    file.write_text(COMPONENT.replace("INTERFACE", interface) + start)
    return said(project, "{node: component/c}")


@pytest.mark.parametrize(
    ("type_", "words"),
    [
        ("sensor_msgs/msg/Image", None),
        ("sensor_msgs/Image", None),
        ("my_msgs/srv/Do", "'my_msgs/srv/Do' isn't a message, and a topic carries messages"),
        ("sensor_msgs/msg/PointClod2", "has no 'msg/PointClod2'; did you mean 'PointCloud2'?"),
        ("std_srvs/srv/Trigger", "'std_srvs/srv/Trigger' isn't a message"),
        ("tf2_msgs/msg/TFMesage", "did you mean 'TFMessage'?"),
        ("std_msgs/msg/Xyz", "has no 'msg/Xyz' (available: std_msgs/msg/Bool, std_msgs/msg/Byte,"),
    ],
)
def test_the_type_of_a_topic_is_looked_up_in_its_package(project, type_, words):
    found = said(project, f"{{node: ros/wait_for_message, with: {{topic: /a, type: {type_}}}}}")
    assert (found == []) if words is None else (len(found) == 1 and words in found[0]), found


def test_the_types_of_several_topics_are_looked_up(project):
    topics = "{/a: std_msgs/msg/String, /b: std_msgs/msg/Strin}"
    (found,) = said(project, f"{{node: ros/wait_for_messages, with: {{topics: {topics}}}}}")
    assert "did you mean 'String'?" in found


@pytest.mark.parametrize(
    ("interface", "words"),
    [
        ("my_msgs/srv/Do", None),
        ("std_srvs/srv/Trigger", None),
        (
            "my_msgs/srv/Du",
            "components/c/component.yaml: the ROS package 'my_msgs' has no 'srv/Du' (available: my_msgs/srv/Do)",
        ),
        ("my_mgs/srv/Do", "'my_mgs' isn't installed; did you mean 'my_msgs'?"),
    ],
)
def test_the_interface_of_a_component_is_looked_up_in_its_own_packages_too(project, interface, words):
    found = with_component(project, interface)
    assert (found == []) if words is None else (len(found) == 1 and words in found[0]), found


def test_a_program_that_a_package_lacks_is_told_with_those_that_it_has(project, tmp_path, monkeypatch):
    prefix = tmp_path / "prefix"
    (prefix / "share" / "my_driver" / "launch").mkdir(parents=True)
    (prefix / "share" / "my_driver" / "launch" / "bringup.launch.xml").write_text("<launch/>")
    program = prefix / "lib" / "my_driver" / "driver_node"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join([str(prefix), sys.prefix]))
    assert with_component(project, "my_msgs/srv/Do", "start: {package: my_driver, executable: driver_node}\n") == []
    (found,) = with_component(project, "my_msgs/srv/Do", "start: {package: my_driver, executable: drivr_node}\n")
    assert "my_driver has no program 'drivr_node'; did you mean 'driver_node'?" in found
    (found,) = with_component(project, "my_msgs/srv/Do", "start: {package: my_driver, launch: bringup.launch.py}\n")
    assert "no launch file 'bringup.launch.py' in " in found
    assert "share/my_driver; did you mean 'launch/bringup.launch.xml'?" in found


def test_the_message_of_a_sensor_is_looked_up(project):
    (project / "grip.yaml").write_text(
        "grip: 1\nsensors:\n  cam:\n    topics: {a: {topic: /a, type: float, message: std_msgs/msg/Flot64}}\n"
    )
    (found,) = said(project, "{node: sensor/cam}")
    assert "grip.yaml: sensors/cam: the ROS package 'std_msgs' has no 'msg/Flot64'; did you mean" in found
