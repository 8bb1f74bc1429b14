"""How a project begins through the server: robots to choose from, folders to browse, what is written, what stays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from played import BASE, PlayedLauncher, TestClient

from grip_bt.app.project.first_motions import BENCH
from grip_bt.app.project.folder import find_project
from grip_bt.base.values import JointState
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.checks import chain_and_checker
from grip_bt.commanders.planning.requests import Situation
from grip_bt.commanders.settings import PlanningSettings
from grip_gui.server import create_app

URDF = """\
<robot name="small">
  <link name="base"/>
  <link name="one"><visual><geometry><box size="0.1 0.1 0.3"/></geometry></visual></link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="one"/><axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def told(page: TestClient, route: str, **given: str) -> Any:
    answer = page.get(f"/api/setup/{route}", params=given)
    assert answer.status_code == 200, answer.text
    return answer.json()


def begun(page: TestClient, **request: Any) -> dict[str, Any]:
    answer = page.post("/api/setup/begin", json=request)
    assert answer.status_code == 200, answer.text
    found: dict[str, Any] = answer.json()
    return found


def test_robots_and_examples_are_told_with_a_sentence_each(page: TestClient) -> None:
    robots = told(page, "robots")
    assert robots["panda"].startswith("The Franka Panda")
    assert all(robots.values())
    assert {"reactive_pick", "count_up"} <= {task for task, doc in told(page, "examples").items() if doc}


def test_arms_with_hands_are_told_with_what_they_are_made_of(page: TestClient) -> None:
    pairs = told(page, "pairs")
    assert (pairs["ur10_allegro"]["arm"], pairs["ur10_allegro"]["hand"]) == ("ur10", "allegro_right")
    assert all(pair["mount"]["link"] for pair in pairs.values())
    assert {pair[part] for pair in pairs.values() for part in ("arm", "hand")} <= told(page, "robots").keys()


def test_a_folder_tells_names_of_folders_and_of_what_can_be_taken(page: TestClient, tmp_path: Path) -> None:
    (tmp_path / "ws" / "arm_moveit" / "config").mkdir(parents=True)
    (tmp_path / "ws" / "arm_moveit" / "config" / "arm.srdf").write_text("<robot/>")
    (tmp_path / "ws" / "arm_description").mkdir()
    (tmp_path / "ws" / "arm_description" / "package.xml").write_text("<package><name>a</name></package>")
    for name in ("arm.urdf", "notes.txt", ".hidden.yaml", "Walk.py"):
        (tmp_path / "ws" / name).write_text("secret")
    found = told(page, "browse", at=str(tmp_path / "ws"))
    assert found["entries"] == {
        "arm_description": "package",
        "arm_moveit": "moveit",
        "arm.urdf": "file",
        "Walk.py": "file",
    }
    assert (found["above"], found["kind"]) == (str(tmp_path), "folder")
    assert told(page, "browse", at="/")["above"] == ""


@pytest.mark.parametrize("at", ["../up", "nowhere", "/nowhere/at/all", "/etc/hostname", "a\0"])
def test_what_is_no_folder_is_refused(page: TestClient, at: str) -> None:
    assert page.get("/api/setup/browse", params={"at": at}).status_code == 404


def test_a_robot_brings_all_that_a_first_task_needs(page: TestClient, project: Path) -> None:
    (project / "grip.yaml").unlink()
    (project / "README.md").write_text("mine")
    made = begun(page, robot="panda")
    assert {"grip.yaml", "tasks/first.yaml", "tasks/take.yaml", "worlds/bench.yaml"} <= set(made["files"])
    assert (project / "README.md").read_text() == "mine"
    view = told(page, "file", path="grip.yaml")
    assert view["problems"] == []
    assert {"robot": "panda", "world": "bench", "sensors": {"overhead": {"camera": "overhead"}}}.items() <= view[
        "data"
    ].items()
    assert told(page, "file", path="worlds/bench.yaml")["problems"] == []
    for task in ("first", "take"):
        problems = page.get("/api/document/problems", params={"path": f"tasks/{task}.yaml"}).json()
        assert problems["problems"] == [], task


def test_what_lacks_is_added_and_what_is_there_stays(page: TestClient, project: Path) -> None:
    mine = "grip: 1\nrobot: panda   # in the lab\narms:\n  right: {group: arm}   # no hand yet\n"
    (project / "grip.yaml").write_text(mine)
    made = begun(page)
    text = (project / "grip.yaml").read_text()
    assert text.startswith(mine)
    assert {"hands", "sensors", "world"} <= set(told(page, "file", path="grip.yaml")["data"])
    assert "grip.yaml" in made["files"]
    assert begun(page)["files"] == []
    assert (project / "grip.yaml").read_text() == text


SHADOW_ON_UR5 = """\
grip: 1
robot:
  arm: ur5   # of the lab
  hand: shadow_right
  mount: {link: tool0, root: rh_forearm, xyz: [0.0, 0.0, 0.01]}
"""


def test_an_arm_with_a_hand_that_reaches_the_bench_at_home_rests_above_it(page: TestClient, project: Path) -> None:
    (project / "grip.yaml").write_text(SHADOW_ON_UR5)
    assert "tasks/take.yaml" in begun(page)["files"]
    assert "arm: ur5   # of the lab" in (project / "grip.yaml").read_text()
    robot = find_project(project).description()
    rest = JointState(robot.joints, [robot.at_rest.get(joint, 0.0) for joint in robot.joints])
    situation = Situation("arm", rest, BENCH, "", PlanningSettings())
    chain, checker = chain_and_checker(RobotModel(robot), situation)
    assert not checker.pairs(rest.ordered(chain.joints))
    assert begun(page)["files"] == []


def test_a_home_that_somebody_has_named_and_that_touches_nothing_stays(page: TestClient, project: Path) -> None:
    named = "  states:\n    arm:\n      home: [0.0, -1.9, 1.0, -1.0, -1.57, 0.0]   # above the vice\n"
    (project / "grip.yaml").write_text(SHADOW_ON_UR5 + named)
    begun(page)
    assert named in (project / "grip.yaml").read_text()


def test_robots_that_are_none_are_refused_and_nothing_is_written(page: TestClient, project: Path) -> None:
    before = sorted(project.rglob("*"))
    for robot in ("", "no_such_robot", "../secret.yaml", "/nowhere/arm.urdf", "\0"):
        answer = page.post("/api/setup/begin", json={"robot": robot})
        assert answer.status_code == 400, answer.text
    assert sorted(path for path in project.rglob("*") if ".grip" not in path.parts) == before


def test_an_example_goes_into_a_folder_that_has_not_begun(page: TestClient, project: Path) -> None:
    assert page.post("/api/setup/begin", json={"example": "count_up"}).status_code == 400
    (project / "grip.yaml").unlink()
    assert begun(page, example="count_up")["files"] == ["tasks/count_up.yaml"]
    assert (project / "tasks" / "count_up.yaml").is_file()
    assert (project / "tasks" / "tiny.yaml").is_file()


def test_a_robot_is_looked_at_before_it_is_taken(page: TestClient, tmp_path: Path) -> None:
    (tmp_path / "small.urdf").write_text(URDF)
    looks = page.get("/api/live/geometry", params={"robot": str(tmp_path / "small.urdf")}).json()
    assert [joint["limits"] for joint in looks["joints"]] == [[-1.0, 2.0]]
    assert looks["groups"]
    assert looks["findings"]
    assert page.get("/api/live/geometry", params={"robot": str(tmp_path / "none.urdf")}).json()["error"]


def test_a_task_is_brought_from_where_it_lies(page: TestClient, project: Path, tmp_path: Path) -> None:
    (tmp_path / "tree.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence><AlwaysSuccess/></Sequence></BehaviorTree></root>'
    )
    brought = page.post("/api/setup/import", json={"source": "btcpp", "path": str(tmp_path / "tree.xml")}).json()
    assert brought["tasks"] == ["tasks/tree.yaml"], brought
    for path in ("../tree.xml", str(tmp_path / "none.xml"), "\0"):
        assert page.post("/api/setup/import", json={"source": "btcpp", "path": path}).status_code == 404
    assert not (project / "legacy").exists()


def test_a_study_adds_up_what_had_the_focus_and_nothing_is_kept_without_one(
    page: TestClient, project: Path, tmp_path: Path
) -> None:
    rows = tmp_path / "out.csv"
    app = create_app(project, PlayedLauncher(), token="right", study=rows)
    with TestClient(app, base_url=BASE, headers={"origin": BASE}) as studied:
        studied.get("/?token=right")
        for window, seconds in (("configure", 0), ("configure", 4.25), ("away", 2)):
            span = {"window": window, "seconds": seconds, "page": "one"}
            assert studied.post("/api/study", json=span).json() is True
    assert page.post("/api/study", json={"window": "run", "seconds": 1}).json() is False
    assert [row.split(",")[1:] for row in rows.read_text().splitlines()] == [
        ["one", "configure", "4.2"],
        ["one", "away", "2.0"],
    ]
