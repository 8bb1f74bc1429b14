"""What runs beside the editor: topics, a server of messages, components with samples, the robot's place."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from played import TASK, TestClient
from test_gui_e2e import SCENARIO, browser, editing

from grip_bt.base.errors import GripError
from grip_bt.base.message_store.text import plain_of, text_of, value_of
from grip_bt.base.value_codec import snapshot
from grip_bt.base.values import JointState, Pose
from grip_bt.ros.environment import own_domain
from grip_bt.runtime import Journal
from grip_bt.runtime.journal import DetailedEvent
from grip_gui.live.ros_client import RosClientProcess
from grip_gui.live.routes import form_of, source_of

COMPONENT = """\
name: switcher
doc: Switches a light.
interface: std_srvs/srv/SetBool
server: /switch
outcomes: {done: "success", refused: "true"}
start: {command: ["{python}", server.py]}
timeouts: {call: 120, ready: 120}
"""
SERVER = """\
import rclpy
from std_srvs.srv import SetBool


def switch(request, response):
    response.success = request.data
    response.message = "switched on" if request.data else "switched off"
    return response


rclpy.init()
node = rclpy.create_node("switcher")
node.create_service(SetBool, "/switch", switch)
rclpy.spin(node)
"""
GRIP = "grip: 1\nrobot: panda_allegro\narms: {right: {group: arm, hand: palm}}\nhands: {palm: {group: hand}}\n"
POSES = """\
bin:
  reference_frame: world
  position: {x: -0.5, y: 0.4, z: 0.1}
  orientation: {r: 0, p: 0, y: 0}
"""


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A DDS domain of the test's own, for all that it starts."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with own_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield str(number)


@pytest.fixture
def world(domain: str) -> Iterator[None]:
    """Somebody who publishes."""
    process = subprocess.Popen([sys.executable, str(Path(__file__).with_name("ros_world.py"))])
    yield
    process.terminate()
    process.wait(120)


@pytest.fixture
def switcher(project: Path) -> Path:
    """A component with its node, named messages, a robot, and a run that wrote a value of the component's input."""
    home = project / "components" / "switcher"
    home.mkdir(parents=True)
    (home / "component.yaml").write_text(COMPONENT)
    (home / "server.py").write_text(SERVER)
    (project / "messages").mkdir()
    (project / "messages" / "poses.yaml").write_text(POSES)
    (project / "grip.yaml").write_text(GRIP)
    with Journal(project / ".grip" / "runs.sqlite") as journal:
        log = journal.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        for variable, type_, value in (("request", "bool", True), ("count", "int", 3)):
            log.note(
                0.0,
                "first",
                DetailedEvent("write", data={"variable": variable, "type": type_}, written=(snapshot(value),)),
            )
        log.end("success", None)
    return home


def ask(page: TestClient, path: str, request: dict[str, Any] | None = None) -> dict[str, Any]:
    answer = page.get(f"/api/live/{path}") if request is None else page.post(f"/api/live/{path}", json=request)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def generated(home: Path) -> None:
    command = [sys.executable, "-m", "grip_bt.cli", "component", "add", str(home)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr


def test_without_ros_every_question_says_what_to_install(
    page: TestClient, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "grip_ros_gone").mkdir()
    # A process that finds no ROS: the file makes every part of it unfindable, as on a machine without it.
    (tmp_path / "grip_ros_gone" / "sitecustomize.py").write_text(
        "import sys\n"
        "class Gone:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'rclpy': raise ModuleNotFoundError(name)\n"
        "sys.meta_path.insert(0, Gone())\n"
        "import importlib.util\n"
        "found = importlib.util.find_spec\n"
        "importlib.util.find_spec = lambda name, package=None: None if name == 'rclpy' else found(name, package)\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "grip_ros_gone"))
    for variable in ("ROS_DISTRO", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(variable, raising=False)
    for path in ("topics", "messages"):
        error = ask(page, path)["error"]
        assert "ROS 2 isn't available here" in error
        assert "pip install 'grip-bt[ros]'" in error


def test_values_are_the_same_after_being_text() -> None:
    pose = Pose([0.1, 0.2, 0.3], [0.5, 0.5, 0.5, 0.5], "table")
    state = JointState(("a", "b"), [0.25, -1.5])
    assert value_of("poses", "there", text_of(pose)) == pose
    assert value_of("joint_states", "there", text_of(state)) == state


@pytest.mark.parametrize(
    ("store", "text", "reason"),
    [
        ("poses", "reference_frame: world\nposition: {x: 1}\norientation: {r: 0, p: 0, y: 0}\n", "has x, y and z"),
        ("poses", "reference_frame: world\nthumb: {position: {x: 0, y: 0, z: 0}}\n", "missing"),
        ("joint_states", "a: fast\n", "a valid number"),
        ("words", "- 1\n", "expected a mapping"),
        ("words", "a: [1\n", "there"),
    ],
)
def test_a_typed_value_that_is_wrong_is_told(store: str, text: str, reason: str) -> None:
    from grip_bt.base.errors import GripError

    with pytest.raises(GripError, match=reason):
        value_of(store, "there", text)


def test_what_is_too_much_is_not_made_text() -> None:
    assert plain_of([1] * 2001) is None
    assert plain_of([1, 2.5, "a"]) == [1, 2.5, "a"]


def test_samples_are_named_by_run_or_store() -> None:
    from grip_bt.base.errors import GripError

    assert source_of("run:20261121-1/7") == {"run": "20261121-1", "seq": 7}
    assert source_of("messages:poses/bin") == {"store": "poses", "name": "bin"}
    with pytest.raises(GripError, match="isn't a sample"):
        source_of("somewhere/else")


def test_a_component_without_a_node_says_what_to_do(project: Path, switcher: Path) -> None:
    assert "Generate its node first" in form_of(project, switcher).error


def test_the_robots_place_is_kept_as_named_messages(page: TestClient, project: Path, switcher: Path) -> None:
    from grip_bt.base.message_store import MessageLibrary

    done = ask(page, "measure", {"robot": "fake", "part": "right", "what": "pose", "name": "here"})
    assert done == {"error": "", "said": "here was written into messages/poses.yaml"}
    done = ask(page, "measure", {"robot": "fake", "part": "palm", "what": "joints", "name": "posture"})
    assert done["error"] == ""
    library = MessageLibrary(project / "messages")
    assert library.store("poses").names() == ("bin", "here")
    assert library.store("joint_states").names() == ("posture",)
    refused = ask(page, "measure", {"robot": "fake", "part": "left", "what": "pose", "name": "x"})
    assert "'left'" in refused["error"]
    refused = ask(page, "measure", {"robot": "fake", "part": "palm", "what": "pose", "name": "x"})
    assert "is a hand" in refused["error"]


@pytest.mark.ros
@pytest.mark.slow
def test_a_component_is_called_with_a_sample_and_answers_field_by_field(
    page: TestClient, project: Path, switcher: Path, domain: str
) -> None:
    generated(switcher)
    (port,) = ask(page, "component?path=components/switcher/component.yaml")["inputs"]
    assert (port["name"], port["type"]) == ("data", "bool")
    (sample,) = port["samples"]
    request = {"path": "components/switcher/component.yaml", "given": [{"port": "data", "sample": sample["source"]}]}
    view = ask(page, "component", request)
    assert (view["error"], view["outcome"]) == ("", "done")
    assert {name: value["text"] for name, value in view["fields"].items()} == {
        "success": "True",
        "message": "switched on",
    }
    request["given"] = [{"port": "data", "text": "maybe"}]
    assert "data" in ask(page, "component", request)["error"]


@pytest.mark.e2e
@pytest.mark.ros
@pytest.mark.slow
def test_what_runs_beside_the_editor_is_seen_in_a_browser(project: Path, switcher: Path, world: None) -> None:
    generated(switcher)
    with editing(project) as (_, url):
        done = subprocess.run(browser("live.mjs", url, str(project)), capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_process_that_looks_at_ros_comes_back_when_it_has_died_and_ends_with_the_editor(
    project: Path, domain: str
) -> None:
    async def asked_twice() -> None:
        window = RosClientProcess(project)
        for _ in range(2):
            with pytest.raises(GripError, match=r"no_such_question|ROS"):
                await window.ask("no_such_question")
            assert window._process is not None
            window._process.kill()
            while window._process is not None:
                await asyncio.sleep(0.01)
        await window.close()

    asyncio.run(asyncio.wait_for(asked_twice(), 120))
