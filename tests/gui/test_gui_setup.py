"""Settings files through the server: as text and as data, changed value by value, checked, saved, tried."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from played import TASK, TestClient

from grip_bt.base.value_codec import snapshot
from grip_bt.base.values import JointState, Pose
from grip_bt.runtime import Journal
from grip_bt.runtime.journal import DetailedEvent
from grip_gui.project import ProjectFolder
from grip_gui.setup.routes import make
from grip_gui.setup.settings_store import UnchangeableError, remove, rename, set_value
from grip_gui.wire.setup import InterfaceRequest

GRIP = """\
grip: 1
robot: panda_allegro      # the one in the lab
arms:
  right: {group: arm, hand: palm, planner: RRTConnect}   # fast enough
hands:
  palm: {group: hand}
world: table
"""
REAL = """\
sensors:
  top: {camera: overhead}
ros:
  controllers: {right: {trajectory: /arm/follow}, palm: {gripper: /hand/close}}   # by hand
  cameras: {top: {image: /top/color, depth: /top/depth, info: /top/info}}
"""
CONTRACT = "sensor_msgs/PointCloud2 input\n---\nint32 outcome\ngeometry_msgs/PoseStamped[] returned_object\n"


def checked(page: TestClient, path: str, text: str) -> dict[str, Any]:
    answer = page.post("/api/setup/check", json={"path": path, "text": text})
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def changed(page: TestClient, **request: Any) -> dict[str, Any]:
    answer = page.post("/api/setup/change", json={"path": "grip.yaml", **request})
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def test_every_settings_file_is_listed_those_to_be_made_too(page: TestClient, project: Path) -> None:
    home = project / "components" / "seer"
    home.mkdir(parents=True)
    (home / "component.yaml").write_text("name: seer\n")
    files = {file["path"]: file["exists"] for file in page.get("/api/setup/files").json()}
    assert files["grip.yaml"] is True
    assert files["components/seer/component.yaml"] is True
    assert files["messages/poses.yaml"] is False


def test_a_form_and_its_text_are_one_thing_and_comments_stay(page: TestClient) -> None:
    view = changed(page, text=GRIP, key=["arms", "right", "planner"], value="BiTRRT")
    assert view["text"] == GRIP.replace("RRTConnect}", "BiTRRT}    ")  # the comment stays in its column
    assert view["data"]["arms"]["right"]["planner"] == "BiTRRT"
    assert view["problems"] == []
    assert view["options"]["arms/*/hand"] == ["palm"]
    assert "BiTRRT" in view["options"]["arms/*/planner"]
    assert view["options"]["arms/*/group"] == ["arm", "hand"]


URDF = """\
<robot name="two">
  <link name="base"/><link name="upper"/><link name="tool"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="tool"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/>
  </joint>
</robot>
"""
DESCRIBED = """\
grip: 1
robot:
  urdf: two.urdf
  groups: {both: {joints: [shoulder, elbow]}}
  states: {both: {folded: [0.5, -0.5]}}
arms:
  only: {group: both}
"""


def test_fields_are_completed_from_a_robot_that_the_project_describes(page: TestClient, project: Path) -> None:
    (project / "two.urdf").write_text(URDF)
    view = checked(page, "grip.yaml", DESCRIBED)
    assert view["problems"] == []
    options = view["options"]
    assert options["arms/*/group"] == ["both"]
    assert options["sensors/*/mount/on"] == ["world", "base", "tool", "upper"]
    assert options["robot/grasp_frames/*/link"] == ["base", "tool", "upper"]
    wrong = checked(page, "grip.yaml", DESCRIBED.replace("group: both", "group: bth"))["problems"]
    assert "did you mean 'both'" in wrong[0]["message"]
    (project / "grip.yaml").write_text(DESCRIBED)
    states = checked(page, "messages/joint_states.yaml", "home: {elbow: 0.1}\n")
    assert states["options"]["*/?"] == ["elbow", "shoulder"]
    assert "upper" in checked(page, "messages/poses.yaml", "{}\n")["options"]["*/reference_frame"]


def test_what_is_wrong_with_a_robots_files_is_marked_at_the_robot_until_it_is_mended(
    page: TestClient, project: Path
) -> None:
    (project / "two.urdf").write_text(URDF.replace('<child link="tool"/>', '<child link="gripper"/>'))
    (problem,) = checked(page, "grip.yaml", DESCRIBED)["problems"]
    assert problem["message"].startswith("robot: ")
    assert "gripper" in problem["message"]
    assert problem["line"] == 2
    (project / "two.urdf").write_text(URDF)
    assert checked(page, "grip.yaml", DESCRIBED)["problems"] == []


def test_a_renamed_hand_is_renamed_where_an_arm_carries_it(page: TestClient) -> None:
    view = changed(page, text=GRIP, do="rename", key=["hands", "palm"], value="right_hand")
    assert view["data"]["arms"]["right"]["hand"] == "right_hand"
    assert view["problems"] == []


def test_a_renamed_sensor_and_arm_keep_their_topics_and_controllers(page: TestClient) -> None:
    view = changed(page, text=GRIP + REAL, do="rename", key=["sensors", "top"], value="overhead")
    assert list(view["data"]["ros"]["cameras"]) == ["overhead"]
    view = changed(page, text=view["text"], do="rename", key=["arms", "right"], value="left")
    assert list(view["data"]["ros"]["controllers"]) == ["left", "palm"]
    assert "# by hand" in view["text"]
    assert view["problems"] == []


def test_a_file_of_a_robot_that_isnt_there_is_missed_in_the_project(page: TestClient, project: Path) -> None:
    (problem,) = checked(page, "grip.yaml", "grip: 1\nrobot: my/robot.urdf\n")["problems"]
    assert f"{project / 'my' / 'robot.urdf'}" in problem["message"]
    assert "there is no such file" in problem["message"]


def test_a_project_that_begins_has_no_fault(page: TestClient) -> None:
    assert checked(page, "grip.yaml", "grip: 1\n")["problems"] == []


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("cameras: {top:", "cameras: {tip:", 12, "ros/cameras/tip: there is no 'tip'; did you mean 'top'?"),
        ("top: {camera: overhead}", "top: {topics: {}}", 12, "no sensor says `camera`"),
        ("palm: {gripper", "plam: {gripper", 11, "ros/controllers/plam: there is no 'plam'; did you mean 'palm'?"),
        ("depth: /top/depth, ", "", 12, "ros/cameras/top: the key 'depth' is missing"),
        ("/top/depth", "top/depth", 12, "'top/depth' isn't a whole ROS name: words of letters, digits and _"),
        ("/top/depth", "/2nd depth", 12, "each after a /, such as /camera/points"),
    ],
)
def test_what_is_wrong_with_the_real_robot_is_said(
    page: TestClient, old: str, new: str, line: int, reason: str
) -> None:
    text = GRIP + REAL
    assert old in text
    problems = checked(page, "grip.yaml", text.replace(old, new))["problems"]
    found = next((p for p in problems if reason in p["message"]), None)
    assert found is not None, problems
    assert found["line"] == line


def test_topics_of_cameras_begin_as_drivers_publish_them(page: TestClient) -> None:
    view = checked(page, "grip.yaml", GRIP + "sensors: {top: {camera: overhead}}\nros: {joint_states: /js}\n")
    template = next(t for t in view["templates"] if t["title"] == "cameras of the real robot")
    made = changed(page, text=view["text"], key=template["key"], value=template["value"])
    assert made["problems"] == []
    assert made["data"]["ros"]["joint_states"] == "/js"
    assert made["data"]["ros"]["cameras"]["top"]["image"] == "/top/color/image_raw"
    assert made["options"]["ros/cameras/?"] == ["top"]


def test_a_fault_names_a_wrong_value_once(page: TestClient) -> None:
    text = GRIP + "sensors: {top: {topics: {cloud: {topic: /points, type: Pointcloud}}}}\n"
    (problem,) = checked(page, "grip.yaml", text)["problems"]
    assert problem["message"].count("'Pointcloud'") == 1


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("RRTConnect", "RTRConnect", 4, "did you mean 'RRTConnect'"),
        ("group: arm", "group: arn", 4, "did you mean 'arm'"),
        ("hand: palm", "hand: pal", 4, "there is no 'pal'"),
        ("panda_allegro", "pandora", 2, "there is no 'pandora'"),
        ("world: table", "world: tabel", 7, "there is no 'tabel'; did you mean 'table'?"),
        ("world: table", "worl: table", 7, "unknown key 'worl' in the file"),
        ("group: hand}", "group: 3}", 6, "hands/palm/group"),
        ("grip: 1", "grip: [1", 1, ""),
    ],
)
def test_what_is_wrong_is_said_with_its_place(page: TestClient, old: str, new: str, line: int, reason: str) -> None:
    problems = checked(page, "grip.yaml", GRIP.replace(old, new))["problems"]
    assert problems, "nothing was found"
    assert reason in problems[0]["message"]
    assert new.startswith("grip:") or problems[0]["line"] == line


def test_several_faults_are_told_at_once(page: TestClient) -> None:
    text = GRIP.replace("RRTConnect}", "A, speed: 7, attempts: 0}")
    assert len(checked(page, "grip.yaml", text)["problems"]) == 3


@pytest.mark.parametrize(
    "path", ["../secret.yaml", "tasks/tiny.yaml", "messages/other.yaml", ".grip/x.yaml", "/etc/a.yaml"]
)
def test_no_other_file_is_read_or_written(page: TestClient, path: str) -> None:
    assert page.get("/api/setup/file", params={"path": path}).status_code == 403
    for route in ("check", "save"):
        assert page.post(f"/api/setup/{route}", json={"path": path, "text": "a: 1"}).status_code == 403
    assert page.post("/api/setup/probe", json={"path": path, "what": "test"}).status_code == 403


def test_a_file_that_somebody_else_has_changed_is_not_overwritten_unasked(page: TestClient, project: Path) -> None:
    known = page.get("/api/setup/file", params={"path": "grip.yaml"}).json()["known"]
    (project / "grip.yaml").write_text("grip: 1\ndoc: theirs\n")
    request = {"path": "grip.yaml", "text": GRIP, "known": known}
    refused = page.post("/api/setup/save", json=request)
    assert (refused.status_code, refused.json()["kind"]) == (409, "disk")
    assert page.post("/api/setup/save", json={**request, "over": True}).status_code == 200
    assert (project / "grip.yaml").read_text() == GRIP


def test_a_new_file_of_messages_is_made_and_read_by_the_projects_library(page: TestClient, project: Path) -> None:
    from grip_bt.base.message_store.library import MessageLibrary

    view = page.get("/api/setup/file", params={"path": "messages/poses.yaml"}).json()
    template = view["templates"][0]
    request = {"path": view["path"], "text": view["text"], "key": template["key"], "value": template["value"]}
    made = page.post("/api/setup/change", json=request).json()
    assert made["problems"] == []
    page.post("/api/setup/save", json={"path": made["path"], "text": made["text"], "known": view["known"]})
    pose = MessageLibrary(project / "messages").store("poses").get("above_table")
    assert pose.position.tolist() == [0.4, 0.0, 0.4]


def test_faults_of_named_poses_are_placed(page: TestClient) -> None:
    problems = checked(page, "messages/poses.yaml", "bin:\n  position: {x: 0}\n")["problems"]
    assert "reference_frame" in problems[0]["message"]
    assert problems[0]["line"] == 1


POSE = "bin: {reference_frame: world, position: {x: 0.4, y: 0, z: 0}, orientation: {r: 0, p: 0, y: 0}}\n"
WAY = "approach:\n- {name: home, interpolate_time: 2.0, pause_time: 0.0}\n"


@pytest.mark.parametrize(
    ("path", "text", "severity", "key", "reason"),
    [
        ("grip.yaml", GRIP.replace("RRTConnect", "RTR"), "error", ["arms", "right", "planner"], "there is no 'RTR'"),
        (
            "messages/joint_states.yaml",
            "home: {panda_joint1: up}\n",
            "error",
            ["home", "panda_joint1"],
            "valid number",
        ),
        (
            "messages/joint_states.yaml",
            "home: {panda_joint1: 0, panda_jont2: 0}\n",
            "warning",
            ["home", "panda_jont2"],
            "did you mean 'panda_joint2'",
        ),
        ("messages/poses.yaml", POSE.replace("0.4", "left"), "error", ["bin", "position", "x"], "not 'left'"),
        (
            "messages/poses.yaml",
            POSE.replace("orien", "orein"),
            "error",
            ["bin", "oreintation"],
            "available: position, orientation",
        ),
        (
            "messages/poses.yaml",
            POSE.replace("world", "wrld"),
            "warning",
            ["bin", "reference_frame"],
            "did you mean 'world'",
        ),
        ("messages/trajectories.yaml", WAY, "error", ["approach", "0", "name"], "there is no 'home'"),
        (
            "messages/trajectories.yaml",
            WAY.replace("2.0", "soon"),
            "error",
            ["approach", "0", "interpolate_time"],
            "valid number",
        ),
    ],
)
def test_what_is_wrong_finds_its_field(
    page: TestClient, project: Path, path: str, text: str, severity: str, key: list[str], reason: str
) -> None:
    (project / "grip.yaml").write_text(GRIP)
    if "soon" in text:
        (project / "messages").mkdir()
        (project / "messages" / "joint_states.yaml").write_text("home: {panda_joint1: 0.0}\n")
    (problem,) = checked(page, path, text)["problems"]
    assert (problem["severity"], problem["key"]) == (severity, key)
    assert reason in problem["message"]


def test_without_a_robot_no_name_is_doubted(page: TestClient) -> None:
    assert checked(page, "messages/poses.yaml", POSE.replace("world", "wrld"))["problems"] == []
    assert checked(page, "messages/joint_states.yaml", "home: {left_knee: 0.0}\n")["problems"] == []


def test_measured_poses_and_joint_states_of_a_run_are_kept_by_name(page: TestClient, project: Path) -> None:
    from grip_bt.base.message_store.library import MessageLibrary

    pose = Pose([0.1, 0.2, 0.3], [0.5, 0.5, 0.5, 0.5], "table")
    state = JointState(("a", "b"), [0.25, -1.5])
    with Journal(project / ".grip" / "runs.sqlite") as journal:
        log = journal.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        for value in (pose, state, "a text"):
            log.note(
                0.0, "first", DetailedEvent("write", data={"variable": "v", "type": "x"}, written=(snapshot(value),))
            )
        log.end("success", None)
    for seq, name in ((1, "seen"), (2, "held")):
        assert page.post("/api/setup/record", json={"run": log.id, "seq": seq, "name": name}).status_code == 200
    library = MessageLibrary(project / "messages")
    assert library.store("poses").get("seen") == pose
    assert library.store("joint_states").get("held") == state
    refused = page.post("/api/setup/record", json={"run": log.id, "seq": 3, "name": "text"})
    assert (refused.status_code, "poses and joint states can" in refused.json()["detail"]) == (400, True)
    assert page.post("/api/setup/record", json={"run": log.id, "seq": 1, "name": "../x"}).status_code == 422


# --- interfaces ---


def look(page: TestClient, **request: Any) -> Any:
    return page.post("/api/setup/interface", json={"type": "my_interfaces/srv/PlanGrasp", "text": CONTRACT, **request})


def test_a_pasted_interface_shows_its_fields_and_its_component_file(page: TestClient) -> None:
    view = look(page, outcomes="one,none", failures=["none"]).json()
    assert [(field["side"], field["name"]) for field in view["fields"]] == [
        ("request", "input"),
        ("response", "outcome"),
        ("response", "returned_object"),
    ]
    assert view["problems"] == []
    assert "outcomes: [one, none]" in view["text"]


SERVED = """from seer.srv import Look

raise SystemExit("it is read, never run")
node.create_service(Look, "seer/look", answer)
"""


def test_an_interface_in_its_own_repository_brings_what_serves_it(
    page: TestClient, project: Path, tmp_path: Path
) -> None:
    repository = tmp_path / "seer"
    files = {
        "package.xml": "<package><name>seer</name><depend>sensor_msgs</depend></package>",
        "srv/Look.srv": "sensor_msgs/PointCloud2 cloud\n---\nbool success\n",
        "scripts/server.py": SERVED,
        "scripts/another.py": "print('nothing')",
    }
    for name, text in files.items():
        (repository / name).parent.mkdir(parents=True, exist_ok=True)
        (repository / name).write_text(text)
    view = look(page, type="", text="", file=str(repository / "srv/Look.srv")).json()
    assert (view["type"], view["server"], view["script"]) == ("seer/srv/Look", "/seer/look", "server.py")
    assert view["problems"] == []
    relative = look(page, type="", text="", file="srv/Look.srv")
    assert (relative.status_code, "isn't a path on this machine" in relative.json()["detail"]) == (400, True)
    asked = InterfaceRequest(file=str(repository / "srv/Look.srv"))
    made, home = make(ProjectFolder(project), asked)
    component = yaml.safe_load((home / "component.yaml").read_text())
    assert component["meaning"] == {"failed": "failure"}, "of outcomes that GRIP has suggested"
    started = component["start"]["command"]
    assert (made.path, started[0]) == ("components/seer_look/component.yaml", "{python}")
    assert (home / started[1]).resolve() == repository / "scripts/server.py"
    assert (home / "interfaces/seer/srv/Look.srv").is_file()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (CONTRACT.replace("int32 outcome", "float32 outcome"), "'outcome' is float32; it must be one integer"),
        (CONTRACT.replace(" input", " inputs"), "the field 'input' is missing; did you mean 'inputs'?"),
        (CONTRACT.replace("returned_object", "result"), "'returned_object' is missing"),
        (CONTRACT.replace("PointCloud2", "PointClod2"), "the field 'input' is of type sensor_msgs/PointClod2"),
        (CONTRACT.replace("PointCloud2", "PointClod2"), "did you mean 'PointCloud2'?"),
        (CONTRACT.replace("geometry_msgs", "geometry_msg"), "did you mean 'geometry_msgs'?"),
        (CONTRACT.replace("sensor_msgs/PointCloud2", "Seen"), "the field 'input' is of type my_interfaces/Seen"),
    ],
)
def test_the_field_that_breaks_the_contract_is_named(page: TestClient, text: str, reason: str) -> None:
    assert any(reason in problem for problem in look(page, text=text, outcomes="a,b").json()["problems"])


def test_outcomes_that_make_no_sense_are_told(page: TestClient) -> None:
    for outcomes in ("1x", "a,a", "found: ;"):
        assert look(page, outcomes=outcomes).json()["problems"], outcomes
    assert look(page, outcomes="a,b", failures=["c"]).json()["problems"]


def test_a_server_that_is_no_ros_name_is_told_in_words(page: TestClient) -> None:
    (problem,) = look(page, outcomes="one,none", server="do it").json()["problems"]
    assert problem == (
        "server: 'do it' isn't a whole ROS name: words of letters, digits and _, each after a /, such as /camera/points"
    )


def test_a_message_of_the_projects_own_packages_is_known(page: TestClient, project: Path) -> None:
    home = project / "components" / "eyes" / "interfaces" / "eyes_interfaces" / "msg"
    home.mkdir(parents=True)
    (home / "Seen.msg").write_text("float64 size\n")
    text = CONTRACT.replace("sensor_msgs/PointCloud2", "eyes_interfaces/Seen")
    assert look(page, text=text, outcomes="one,none").json()["problems"] == []


@pytest.mark.parametrize("asked", [{"type": "no"}, {"text": "int32 a b c\n"}, {"type": "x_y/srv/Z", "text": ""}])
def test_what_is_no_interface_is_refused_with_the_reason(page: TestClient, asked: dict[str, str]) -> None:
    answer = look(page, **asked)
    assert answer.status_code in {400, 404}
    assert answer.json()["detail"]


def test_an_installed_type_is_taken_by_its_name(page: TestClient) -> None:
    view = look(page, type="std_srvs/srv/Trigger", text="").json()
    assert [field["name"] for field in view["fields"]] == ["success", "message"]
    assert view["suggestion"] == "done: success; failed: not success"
    assert view["problems"] == []


@pytest.mark.ros
def test_a_component_is_made_generated_and_offered_as_a_node(page: TestClient, project: Path) -> None:
    view = look(page, outcomes="one,none", failures=["none"], name="seer", create=True).json()
    assert view["path"] == "components/seer/component.yaml"
    assert (project / "components" / "seer" / "node" / "manifest.yaml").is_file(), view["output"]
    nodes = {node["id"] for node in page.get("/api/catalog").json()["nodes"]}
    assert "component/seer" in nodes
    again = look(page, outcomes="one,none", name="seer", create=True)
    assert (again.status_code, "already exists" in again.json()["detail"]) == (400, True)


def test_only_one_try_at_a_time_and_only_of_its_kind(page: TestClient) -> None:
    answer = page.post("/api/setup/probe", json={"path": "grip.yaml", "what": "test"})
    assert (answer.status_code, "component" in answer.json()["detail"]) == (400, True)


# --- changes of values in texts ---

KEYS = st.sampled_from(["a", "b", "c"])
VALUES = st.recursive(
    st.integers(-9, 9) | st.booleans() | st.sampled_from(["x", "no", "1", ""]),
    lambda inner: st.dictionaries(KEYS, inner, max_size=2) | st.lists(inner, max_size=2),
    max_leaves=5,
)


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(st.lists(KEYS, min_size=1, max_size=3), VALUES), max_size=6))
def test_a_text_says_what_was_put_into_it_and_nothing_else_changes(steps: list[tuple[list[str], Any]]) -> None:
    from ruamel.yaml import YAML

    text, data = "# kept\n", {}
    for key, value in steps:
        at: Any = data
        for step in key[:-1]:
            at = at.setdefault(step, {}) if isinstance(at, dict) else None
        if not isinstance(at, dict):
            with pytest.raises(UnchangeableError):
                set_value(text, key, value)
            return
        at[key[-1]] = value
        text = set_value(text, key, value)
        assert YAML(typ="safe").load(text) == data


def test_removing_and_renaming_keep_the_rest() -> None:
    text = "a: 1   # one\nb:\n  c: 2\nd: 3\n"
    assert remove(text, ["b", "c"]) == "a: 1   # one\nd: 3\n"
    assert rename(text, ["a"], "z") == "z: 1   # one\nb:\n  c: 2\nd: 3\n"
    with pytest.raises(UnchangeableError, match="taken"):
        rename(text, ["a"], "d")
    for broken in ("a: [1", "- 1", "a: &x [*x"):
        with pytest.raises(UnchangeableError):
            set_value(broken, ["a"], 1)
    with pytest.raises(UnchangeableError, match="isn't there"):
        remove(text, ["b", "x"])
