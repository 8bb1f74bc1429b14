"""A project with components that misbehave in one way each, all with one small interface."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

PACKAGE = """<?xml version="1.0"?>
<package format="3">
  <name>trial_interfaces</name><version>0.1.0</version><description>A number in, a number out.</description>
  <maintainer email="maintainer@example.com">GRIP</maintainer><license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend><buildtool_depend>rosidl_default_generators</buildtool_depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
</package>
"""
SRV = "int32 input\n---\nint32 outcome\nint32 returned_object\n"
COMPONENT = """name: {name}
doc: A component for trials.
interface: trial_interfaces/srv/Ask
server: /{name}
outcomes: [fine, poor]
meaning: {{poor: failure}}
ports: {{input: {{type: int}}, returned_object: {{type: int}}}}
start: {{command: ["{{python}}", server.py]}}
timeouts: {{call: 120, ready: {ready}}}
"""
SERVER = """import os
import rclpy
from rclpy.node import Node
from trial_interfaces.srv import Ask

def answer(request, response):
    {body}
    return response

rclpy.init()
node = Node("{name}")
node.create_service(Ask, "/{name}", answer)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""
BODIES = {
    "good": "response.outcome, response.returned_object = 0, request.input + 1",
    "dies_in_a_call": "os._exit(7)",
    "out_of_range": "response.outcome = 5",
    "says_its_domain": "response.returned_object = int(os.environ['ROS_DOMAIN_ID'])",
}
NEVER_COMES = 'import sys\nprint("the camera licence has expired")\nsys.exit(3)\n'
TASK = """grip: 1
name: ask
data: {{question: {{type: int, value: 41}}, answer: int}}
outcomes: {{answered: success, unanswered: failure}}
root:
  kind: state_machine
  initial: ask
  outcomes: {{answered: success, unanswered: failure}}
  on: {{answered: answered, unanswered: unanswered}}
  children:
    ask:
      node: component/{name}
      in: {{input: question}}
      out: {{returned_object: answer}}
      on: {{fine: tell, poor: unanswered, failure: unanswered}}
    tell: {{node: flow/log, with: {{message: answered}}, on: {{success: answered}}}}
"""


def make_trial_project(folder: Path) -> Path:
    """Write the project, generate the nodes of its components, and return its folder."""
    (folder / "grip.yaml").write_text("grip: 1\n")
    (folder / "tasks").mkdir()
    for name in (*BODIES, "never_comes"):
        part = folder / "components" / name
        interface = part / "interfaces" / "trial_interfaces"
        (interface / "srv").mkdir(parents=True)
        (interface / "package.xml").write_text(PACKAGE)
        (interface / "srv" / "Ask.srv").write_text(SRV)
        (part / "component.yaml").write_text(COMPONENT.format(name=name, ready=10 if name == "never_comes" else 120))
        server = NEVER_COMES if name == "never_comes" else SERVER.format(name=name, body=BODIES[name])
        (part / "server.py").write_text(server)
        (folder / "tasks" / f"{name}.yaml").write_text(TASK.format(name=name))
        done = grip("component", "add", str(part))
        assert done.returncode == 0, done.stderr
    return folder


def grip(*arguments: str, domain: int = 0, timeout: float = 600) -> subprocess.CompletedProcess[str]:
    """Run the command and return what it said."""
    env = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-m", "grip_bt.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, env=env)


def result_of(done: subprocess.CompletedProcess[str]) -> dict:
    """Return the JSON object that `grip run --json` printed last."""
    return json.loads(done.stdout.strip().splitlines()[-1])


def processes_in(folder: Path) -> list[str]:
    """Return the command lines of processes that were started for this folder."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != os.getpid():
            try:
                words = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                where = os.readlink(entry / "cwd")
            except OSError:
                continue  # it has ended meanwhile, or isn't ours
            if str(folder) in words or where.startswith(str(folder)):
                found.append(words)
    return found
