"""Components are started by command, from a ROS package, by a launch file, or not at all."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from ros_bench import DATA, ended, gone

from grip_bt.base.failures import ServerLostError
from grip_bt.ros.command import program_of
from grip_bt.ros.components import start_components
from grip_bt.ros.interfaces.packages import PackageError, executable_of, launch_file_of, share_of

TEXT = """
name: trigger
interface: std_srvs/srv/Trigger
server: %s
outcomes: {done: success, failed: "true"}
start: %s
timeouts: {call: 400, ready: 400}
"""
SERVER = f"{sys.executable} {DATA / 'servers.py'} std_srvs/Trigger /trigger"


@pytest.fixture
def component(tmp_path):
    """Return a function that writes the component and starts it."""
    home = tmp_path / "components" / "trigger"
    home.mkdir(parents=True)

    def start(how: str, domain: int, server: str = "/trigger"):
        (home / "component.yaml").write_text(TEXT % (server, how))
        return start_components(tmp_path, ["trigger"], domain)

    start.home = home
    return start


@pytest.fixture
def prefix(tmp_path, monkeypatch) -> Path:
    """Return a prefix on the search path, with one package: a program and a launch file."""
    root = tmp_path / "prefix"
    program = root / "lib" / "trigger_pkg" / "server"
    program.parent.mkdir(parents=True)
    program.write_text(f'#!/bin/sh\nexec {SERVER} "$@"\n')
    program.chmod(0o755)
    launch = root / "share" / "trigger_pkg" / "launch"
    launch.mkdir(parents=True)
    (launch / "up.launch.xml").write_text("<launch><!-- serve --></launch>")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(root))
    return root


@pytest.mark.ros
def test_a_program_of_a_package_is_started(component, prefix, domain):
    with component("{package: trigger_pkg, executable: server}", domain) as components:
        assert ended(components.client("trigger").call({}))["success"] is True


@pytest.fixture
def ros2(tmp_path, monkeypatch) -> Path:
    """Return what stands for ROS's own tools: it serves as a launch file that says `serve` would have it."""
    tool = tmp_path / "bin" / "ros2"
    tool.parent.mkdir()
    tool.write_text(f'#!/bin/sh\ngrep -q serve "$2" && {SERVER} || echo "wrong: $2 $3"\n')
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tool.parent}:{os.environ['PATH']}")
    return tool


@pytest.mark.ros
@pytest.mark.slow
@pytest.mark.parametrize("how", ["launch: up.launch.xml", "package: trigger_pkg, launch: up.launch.xml"])
def test_a_launch_file_is_started_and_all_of_it_ends_with_the_component(component, prefix, ros2, domain, how):
    (component.home / "up.launch.xml").write_text("<launch><!-- serve --></launch>")
    with component("{" + how + ", arguments: {name: it}}", domain) as components:
        assert ended(components.client("trigger").call({}))["success"] is True
        pid = components.process("trigger").pid
    assert gone(pid)


PLAIN = """<launch>
  <arg name="python"/> <arg name="name" default="/elsewhere"/>
  <executable cmd="$(var python) '$(dirname)/serve.py' std_srvs/Trigger $(var name)"/>
</launch>"""


@pytest.mark.ros
def test_a_launch_file_of_one_program_needs_none_of_ros_tools(component, monkeypatch, domain):
    monkeypatch.setattr("shutil.which", lambda name: None)
    (component.home / "serve.py").symlink_to(DATA / "servers.py")
    (component.home / "up.launch.xml").write_text(PLAIN)
    with component('{launch: up.launch.xml, arguments: {python: "{python}", name: /trigger}}', domain) as components:
        assert ended(components.client("trigger").call({}))["success"] is True


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (PLAIN, "its argument 'python' has no value; give one under `arguments:`"),
        (
            "<launch><executable cmd='a'/><executable cmd='b'/></launch>",
            "run by `ros2 launch`, which isn't on the path",
        ),
        ("<launch><group><executable cmd='a'/></group></launch>", "source a ROS that has it"),
        ("<launch/>", "or say what to start by `command:`"),
    ],
)
def test_what_only_ros_can_launch_is_told(tmp_path, text, said):
    file = tmp_path / "up.launch.xml"
    file.write_text(text)
    with pytest.raises(PackageError, match=said):
        program_of(file, {})


def test_values_of_a_launch_file_are_one_word_each(tmp_path):
    file = tmp_path / "up.launch.xml"
    file.write_text(PLAIN)
    words = program_of(file, {"python": "/my python", "name": "$(var python) b"})
    assert words == ["/my python", f"{tmp_path}/serve.py", "std_srvs/Trigger", "$(var python) b"]


@pytest.mark.ros
def test_a_program_is_started_in_a_namespace(component, prefix, domain):
    command = ["{python}", str(DATA / "servers.py"), "std_srvs/Trigger", "trigger"]
    with component(f"{{command: {command}, namespace: /left}}", domain, "/left/trigger") as components:
        assert ended(components.client("trigger").call({}))["success"] is True


@pytest.mark.ros
def test_what_is_not_to_be_run_is_not_started_twice(component, domain, serve):
    serve("std_srvs/Trigger", "/trigger")
    with component(f"{{command: [{', '.join(SERVER.split())}], run: false}}", domain) as components:
        assert components.process("trigger") is None
        assert ended(components.client("trigger").call({}))["success"] is True


@pytest.mark.ros
def test_what_a_launch_file_says_that_is_wrong_is_quoted(component, ros2, domain):
    (component.home / "up.launch.xml").write_text("<launch/>")
    with pytest.raises(ServerLostError, match=r"wrong: .*up.launch.xml name:=it"):
        component("{launch: up.launch.xml, arguments: {name: it}}", domain)


def test_what_a_package_does_not_have_is_named_with_what_it_has(prefix):
    assert executable_of("trigger_pkg", "server") == prefix / "lib" / "trigger_pkg" / "server"
    with pytest.raises(PackageError, match=r"no ROS package 'trigger_pk' here; did you mean 'trigger_pkg'"):
        share_of("trigger_pk")
    with pytest.raises(PackageError, match=r"has no program 'serve'; did you mean 'server'"):
        executable_of("trigger_pkg", "serve")
    with pytest.raises(PackageError, match=r"no launch file 'up.launch.py' in .*available: .*up.launch.xml"):
        launch_file_of("trigger_pkg", "up.launch.py")
