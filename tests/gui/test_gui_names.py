"""What forms offer: names of robot and messages for the parameters of leaves, and templates that fit the project."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from played import TestClient

from grip_gui.setup.options import names_of

GRIP = """\
grip: 1
robot: panda_allegro
arms: {right: {group: arm, hand: palm}}
hands: {palm: {group: hand}}
"""
STATES = "ready: {panda_joint1: 0.1}\nabove: {panda_joint1: 0.2}\n"


@pytest.fixture
def robot(project: Path) -> Path:
    (project / "grip.yaml").write_text(GRIP)
    (project / "messages").mkdir()
    (project / "messages" / "joint_states.yaml").write_text(STATES)
    (project / "messages" / "poses.yaml").write_text(
        "bin: {reference_frame: world, position: {x: 0, y: 0, z: 0}, orientation: {r: 0, p: 0, y: 0}}\n"
    )
    return project


def opened(page: TestClient, path: str) -> dict[str, Any]:
    answer = page.get("/api/setup/file", params={"path": path})
    assert answer.status_code == 200, answer.text
    view: dict[str, Any] = answer.json()
    return view


def test_parameters_of_leaves_are_completed_from_the_robot_and_the_messages(page: TestClient, robot: Path) -> None:
    places = page.get("/api/setup/names").json()
    assert places["*/*/arm"] == ["right"]
    assert places["*/*/hand"] == ["palm"]
    assert "home" in places["arm/*/state"]
    assert {"open", "closed"} & set(places["hand/*/posture"])
    assert places["messages/*/name"] == ["above", "bin", "ready"]
    assert "panda_link0" in places["*/*/frame"]


def test_a_renamed_arm_is_offered_by_its_new_name_at_once(page: TestClient, robot: Path) -> None:
    (robot / "grip.yaml").write_text(GRIP.replace("right", "left"))
    assert page.get("/api/setup/names").json()["*/*/arm"] == ["left"]


@pytest.mark.parametrize("text", ["grip: 1\n", "grip: [1", "grip: 1\nrobot: nobody\n", "arms: 3\n"])
def test_without_a_robot_there_is_still_what_needs_none(project: Path, text: str) -> None:
    (project / "grip.yaml").write_text(text)
    places = names_of(project)
    assert places["scene/add_shape/shape"] == ["box", "cylinder", "sphere"]
    assert not places.get("arm/*/state")


def test_an_arm_that_joins_others_has_the_states_that_all_of_them_have(project: Path) -> None:
    (project / "grip.yaml").write_text(
        "grip: 1\nrobot: two_ur5_allegro\narms:\n  left: {group: left_arm}\n  right: {group: right_arm}\n"
        "  both: {group: arms, arms: [left, right]}\n"
    )
    assert "home" in names_of(project)["arm/*/state"]


def test_templates_of_joint_states_have_the_joints_of_the_robot_within_their_limits(
    page: TestClient, robot: Path
) -> None:
    templates = {template["title"]: template for template in opened(page, "messages/joint_states.yaml")["templates"]}
    arm = templates["a joint state of arm"]["value"]
    assert list(arm) == [f"panda_joint{number}" for number in range(1, 8)]
    assert arm["panda_joint4"] < -0.1  # at zero it would be out of its limits
    assert len(templates["a joint state of hand"]["value"]) == 16


def test_a_template_of_a_trajectory_goes_through_states_that_there_are(page: TestClient, robot: Path) -> None:
    view = opened(page, "messages/trajectories.yaml")
    (template,) = view["templates"]
    request = {"path": view["path"], "text": view["text"], "key": template["key"], "value": template["value"]}
    made = page.post("/api/setup/change", json=request).json()
    assert made["problems"] == []
    assert [waypoint["name"] for waypoint in made["data"]["approach"]] == ["ready", "above"]
    assert made["options"]["*/*/name"] == ["ready", "above"]


def test_every_template_of_a_project_is_taken_or_marked_where_a_path_or_a_name_has_to_be_put_in(
    page: TestClient, robot: Path
) -> None:
    said = {}
    view = opened(page, "grip.yaml")
    for template in view["templates"]:
        request = {"path": "grip.yaml", "text": view["text"], "key": template["key"], "value": template["value"]}
        problems = page.post("/api/setup/change", json=request).json()["problems"]
        if problems:
            said[template["title"]] = problems[0]["message"]
    assert set(said) == {
        "a robot from a URDF or xacro file",
        "a robot from a MoveIt package",
        "an arm with a hand",
    }
    assert "robot.urdf.xacro" in said["a robot from a URDF or xacro file"]
    assert "my_robot_moveit_config" in said["a robot from a MoveIt package"]
    assert "arms/right/hand: there is no 'right_hand'" in said["an arm with a hand"]


def test_controllers_of_the_real_robot_begin_with_one_for_each_arm_and_hand(page: TestClient, robot: Path) -> None:
    view = opened(page, "grip.yaml")
    template = next(t for t in view["templates"] if t["title"] == "controllers of the real robot")
    request = {"path": "grip.yaml", "text": view["text"], "key": template["key"], "value": template["value"]}
    made = page.post("/api/setup/change", json=request).json()
    assert made["problems"] == []
    assert list(made["data"]["ros"]["controllers"]) == ["right", "palm"]
    assert made["options"]["ros/controllers/?"] == ["right", "palm"]
