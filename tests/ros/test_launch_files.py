"""Launch files read without ROS's tools: what is understood is resolved exactly, what isn't is refused by name."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from grip_bt.ros.launch import LaunchError, read_launch_file
from grip_bt.ros.launch.interpreter import members_of_file


@pytest.fixture
def prefix(tmp_path) -> Path:
    """Return a prefix with one package that has one program and one launch file."""
    root = tmp_path / "prefix"
    program = root / "lib" / "arm_driver" / "driver"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    share = root / "share" / "arm_driver" / "launch"
    share.mkdir(parents=True)
    (share / "inner.launch.xml").write_text('<launch><arg name="n"/><executable cmd="echo $(var n)"/></launch>')
    (root / "share" / "ament_index").mkdir()
    return root


def read(tmp_path: Path, text: str, prefix: Path | None = None, name="it.launch.xml", env=None, **arguments: str):
    file = tmp_path / name
    file.write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMENT_PREFIX_PATH", str(prefix or ""))
        return read_launch_file(file, arguments, env)


def commands(launch) -> list[str]:
    return [" ".join(p.command) for p in launch]


XML = """<launch>
  <arg name="ip" default="10.0.0.1" description="address"/>
  <let name="ns" value="left"/>
  <group>
    <push_ros_namespace namespace="$(var ns)"/>
    <set_remap from="a" to="b"/>
    <node pkg="arm_driver" exec="driver" name="driver" namespace="arm" args="--fast 'two words'">
      <param name="ip" value="$(var ip)"/>
      <param name="gains"><param name="p" value="1.5"/></param>
      <param name="label" value="7" type="str"/>
      <param name="joints" value="j1,j2" value-sep=","/>
      <remap from="joint_states" to="/joint_states"/>
      <env name="MODE" value="slow"/>
    </node>
  </group>
  <node pkg="arm_driver" exec="driver" unless="$(equals $(var ip) 10.0.0.1)"/>
</launch>"""

YAML = """launch:
- arg: {name: ip, default: 10.0.0.1, description: address}
- let: {name: ns, value: left}
- group:
  - push_ros_namespace: {namespace: $(var ns)}
  - set_remap: {from: a, to: b}
  - node:
      pkg: arm_driver
      exec: driver
      name: driver
      namespace: arm
      args: --fast 'two words'
      param:
      - {name: ip, value: $(var ip)}
      - name: gains
        param: [{name: p, value: 1.5}]
      - {name: label, value: 7, type: str}
      - {name: joints, value: "j1,j2", value-sep: ","}
      remap:
      - {from: joint_states, to: /joint_states}
      env:
      - {name: MODE, value: slow}
- node: {pkg: arm_driver, exec: driver, unless: $(equals $(var ip) 10.0.0.1)}
"""


def test_a_node_gets_its_name_name_space_remappings_and_parameters(tmp_path, prefix):
    (process,) = read(tmp_path, XML, prefix)
    program = str(prefix / "lib" / "arm_driver" / "driver")
    assert process.command == (
        *(program, "--fast", "two words", "--ros-args", "-r", "__node:=driver", "-r", "__ns:=/left/arm"),
        *("-r", "a:=b", "-r", "joint_states:=/joint_states", "-p", "ip:=10.0.0.1", "-p", "gains.p:=1.5"),
        *("-p", "label:='7'", "-p", "joints:=[j1, j2]"),
    )
    assert (process.env, process.name) == ({"MODE": "slow"}, "driver")


def test_an_argument_decides_over_conditions(tmp_path, prefix):
    assert len(read(tmp_path, XML, prefix, ip="1.2.3.4")) == 2


def test_settings_of_a_group_end_with_it(tmp_path, prefix):
    second = read(tmp_path, XML, prefix, ip="1.2.3.4")[1]
    assert second.command[1:] == ()


def test_includes_take_arguments_and_relative_files(tmp_path, prefix):
    (tmp_path / "other.launch.yaml").write_text(
        "launch:\n- arg: {name: n}\n- executable: {cmd: echo $(var n) $(dirname), name: said}\n"
    )
    text = """<launch>
      <include file="$(find-pkg-share arm_driver)/launch/inner.launch.xml"><arg name="n" value="3"/></include>
      <include file="other.launch.yaml"><let name="n" value="4"/></include>
    </launch>"""
    assert commands(read(tmp_path, text, prefix)) == ["echo 3", f"echo 4 {tmp_path}"]


def test_the_yaml_form_means_the_same(tmp_path, prefix):
    for given in ({}, {"ip": "1.2.3.4"}):
        yaml = read(tmp_path, YAML, prefix, "it.launch.yaml", **given)
        xml = read(tmp_path, XML, prefix, **given)
        assert [(p.name, p.command, p.env) for p in yaml] == [(p.name, p.command, p.env) for p in xml]


def test_environment_of_the_shell_defaults_and_nested_logic(tmp_path, monkeypatch):
    monkeypatch.setenv("CELL", "3")
    text = """<launch>
      <executable cmd="echo $(env CELL) $(env NOT_THERE none)" if="$(and true $(not $(equals $(env CELL) '4')))"/>
      <executable cmd="no" if="$(or 0 false)"/>
      <unset_env name="CELL"/> <executable cmd="env"/>
    </launch>"""
    said, env = read(tmp_path, text, env={"CELL": "3", "HOME": "/"})
    assert said.command == ("echo", "3", "none")
    assert (said.env, env.env) == ({"CELL": "3", "HOME": "/"}, {"HOME": "/"})


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("<launch><nodes/></launch>", ":1: <nodes> is not supported; did you mean 'node'"),
        (
            '<launch>\n<node pkg="a" exe="b"/></launch>',
            ":2: <node>: the attribute 'exe' is not supported; did you mean 'exec'",
        ),
        ('<launch><node pkg="nope" exec="b"/></launch>', "no ROS package 'nope' here"),
        ('<launch><node pkg="arm_driver" exec="drive"/></launch>', "no program 'drive'; did you mean 'driver'"),
        (
            '<launch><executable cmd="echo $(var nam)"/><arg name="name" default=""/></launch>',
            r"\$\(var nam\): there is none",
        ),
        ('<launch><executable cmd="echo $(evil x)"/></launch>', r"unknown substitution \$\(evil ...\)"),
        ('<launch><executable cmd="echo $(command ls)"/></launch>', r"\$\(command ...\) isn't run here"),
        ('<launch><executable cmd="echo $(var a"/></launch>', "closing bracket is missing"),
        ('<launch><arg name="robot"/></launch>', "the argument 'robot' is needed: robot:=VALUE"),
        ('<launch><executable cmd="x" if="maybe"/></launch>', "`if` is true, false, 1 or 0, not 'maybe'"),
        ('<launch><include file="gone.launch.xml"/></launch>', "gone.launch.xml"),
        ('<launch><node pkg="arm_driver" exec="driver"><param from="gone.yaml"/></node></launch>', "no file gone.yaml"),
        ("<launch><executable></launch>", "XML: mismatched tag"),
        ("<robot/>", "begins with <launch>, not with <robot>"),
        ('<!DOCTYPE l [<!ENTITY a "b">]><launch/>', "declares an entity"),
        ('<launch><composable_node pkg="a" plugin="b"/></launch>', "<composable_node> is not supported"),
        ('<launch><arg name="a" default="x"><choice value="y"/></arg></launch>', "a:=x: not one of y"),
        ("<launch>" + "<group>" * 5000 + "</group>" * 5000 + "</launch>", "nested more than 50 deep"),
        ('<launch><executable cmd="' + "$(not " * 5000 + ")" * 5000 + '"/></launch>', "more than 100 substitutions"),
        ('<launch><include file="$(dirname)/it.launch.xml"/></launch>', "more than 30 deep"),
    ],
)
def test_what_is_wrong_or_not_understood_is_refused_by_name_and_line(tmp_path, prefix, text, reason):
    with pytest.raises(LaunchError, match=reason):
        read(tmp_path, text, prefix)


BRINGUP = """<?xml version="1.0"?>
<launch>
  <arg name="ur_type" default="ur5e" description="which robot"><choice value="ur5e"/><choice value="ur10e"/></arg>
  <arg name="use_sim_time" default="false"/>
  <let name="description"
       value="$(command 'xacro $(find-pkg-share arm_driver)/urdf/arm.urdf.xacro name:=$(var ur_type)')"/>
  <group>
    <push_ros_namespace namespace="left"/>
    <set_use_sim_time value="$(var use_sim_time)"/>
    <set_parameters_from_file filename="$(dirname)/common.yaml"/>
    <node pkg="arm_driver" exec="driver" name="publisher" output="screen">
      <param name="robot_description" value="$(var description)" type="str"/>
      <param name="gains"><param name="p" value="1.5"/></param>
    </node>
  </group>
</launch>
"""
ARM = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="name" default="none"/><link name="$(arg name)_base"/></robot>"""


def test_a_bringup_file_as_robots_come_with_expands_its_description(tmp_path, prefix):
    urdf = prefix / "share" / "arm_driver" / "urdf"
    urdf.mkdir(parents=True)
    (urdf / "arm.urdf.xacro").write_text(ARM)
    (tmp_path / "common.yaml").write_text("/**: {ros__parameters: {rate: 10}}\n")
    launch = read(tmp_path, BRINGUP, prefix, ur_type="ur10e", use_sim_time="true")
    (process,) = launch
    words = list(process.command)
    assert {"__ns:=/left", "use_sim_time:=true", str(tmp_path / "common.yaml"), "gains.p:=1.5"} <= set(words)
    (description,) = [w for w in words if w.startswith("robot_description:='")]
    assert '<link name="ur10e_base"/>' in description
    (tmp_path / "common.yaml").unlink()
    with pytest.raises(LaunchError, match="there is no file .*common.yaml"):
        read(tmp_path, BRINGUP, prefix)
    (urdf / "arm.urdf.xacro").write_text(ARM.replace("$(arg name)", "$(arg nam)"))
    with pytest.raises(LaunchError, match=r":[56]: \$\(command 'xacro ...'\): .*nam"):
        read(tmp_path, BRINGUP, prefix)


def test_an_argument_that_the_file_does_not_have_is_refused(tmp_path):
    with pytest.raises(LaunchError, match=r"no argument 'robot_pi'; did you mean 'robot_ip'"):
        read(tmp_path, '<launch><arg name="robot_ip" default=""/></launch>', robot_pi="1")


def test_nothing_of_a_file_is_executed_while_it_is_read(tmp_path):
    text = '<launch><executable cmd="touch $(dirname)/x; $(var a `id`)"/></launch>'
    read(tmp_path, text)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    "line",
    [
        '<arg name="model" default="$(find ur_description)/x.urdf"/>',
        '<param name="robot_description" command="xacro x"/>',
        '<group ns="left"/>',
        '<node pkg="p" type="talker.py" name="talker" required="true"/>',
        '<rosparam command="load" file="x.yaml"/>',
    ],
)
def test_a_ros_1_file_is_told_as_such_with_where_to_read_what_changes(tmp_path, line):
    with pytest.raises(LaunchError, match=r"old.launch:2: this is a ROS 1 launch file: .*docs/launching.md lists"):
        read(tmp_path, f"<launch>\n  {line}\n</launch>", name="old.launch")


def test_a_python_launch_file_is_refused_where_the_launch_package_is_missing(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", os.path.dirname("/usr/bin/env"))
    file = tmp_path / "it.launch.py"
    file.write_text("raise SystemExit('executed')")
    with pytest.raises(LaunchError, match="source a ROS that has it"):
        members_of_file(file, {})


def test_ros_own_tools_are_used_where_they_are(tmp_path, monkeypatch):
    ros2 = tmp_path / "bin" / "ros2"
    ros2.parent.mkdir()
    ros2.write_text("#!/bin/sh\n")
    ros2.chmod(0o755)
    file = tmp_path / "it.launch.py"
    file.write_text("")
    monkeypatch.setenv("PATH", f"{ros2.parent}:/usr/bin:/bin")
    (member,) = members_of_file(file, {"robot_ip": "10.0.0.2"})
    assert list(member.command) == [str(ros2), "launch", str(file), "robot_ip:=10.0.0.2"]
