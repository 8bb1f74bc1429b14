"""A new project for a robot with an arm and a hand has a task in which the hand takes something and holds it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.first_motions import first_grasp
from grip_bt.app.project.folder import find_project, make_project
from grip_bt.app.project.new_robot import new_robot
from grip_bt.app.runs.execute import run
from grip_bt.commanders.description.load import load_robot
from grip_bt.task.document import read
from grip_bt.task.validation import validate
from grip_gui.setup.beginning import begin
from grip_sim.worlds import load_world


def made(robot: str, folder: Path) -> set[str]:
    files = new_robot(robot, folder, lambda question, names: names[0]).files
    make_project(folder, files)
    return set(files)


@pytest.mark.parametrize(("robot", "thing"), [("ur5_gripper", "block"), ("ur10_shadow", "can")])
def test_two_fingers_get_a_block_and_more_a_can_in_a_task_without_problems(robot, thing, tmp_path):
    assert {"tasks/take.yaml", "worlds/bench.yaml"} <= made(robot, tmp_path)
    project = find_project(tmp_path)
    assert project.file.world == "bench"
    assert list(project.file.sensors) == ["overhead"]
    (there,) = load_world("bench", 0, tmp_path).objects
    assert there.name == thing
    document = read(tmp_path / "tasks" / "take.yaml")
    assert list(validate(document.task, catalogue_of(project), document).issues) == []
    place = document.task.data["place"].value
    assert abs(place["position"][0] - there.position[0]) + abs(place["position"][1] - there.position[1]) < 0.1


def test_an_arm_that_rests_in_another_state_than_home_takes_something_too():
    robot = load_robot("ur5_gripper")
    states = {
        group: {"ready" if n == "home" else n: q for n, q in of.items()} for group, of in robot.named_states.items()
    }
    files = first_grasp(replace(robot, named_states=states), str)
    assert "state: ready" in files["tasks/take.yaml"]
    assert first_grasp(replace(robot, named_states={}), str) == {}


@pytest.mark.parametrize(("robot", "world"), [("allegro_right", "table"), ("ur5", "table")])
def test_what_has_no_arm_or_no_hand_takes_nothing(robot, world, tmp_path):
    assert made(robot, tmp_path) == {"grip.yaml", "tasks/first.yaml"}
    assert find_project(tmp_path).file.world == world


@pytest.mark.sim
def test_the_hand_holds_it_in_simulation(tmp_path):
    made("panda_allegro", tmp_path)
    make_project(tmp_path / "plain")  # its files were found so
    plain, own = (read(folder / "tasks" / "take.yaml").task for folder in (tmp_path / "plain", tmp_path))
    assert plain.data == own.data
    worlds = [(folder / "worlds" / "bench.yaml").read_text() for folder in (tmp_path / "plain", tmp_path)]
    assert worlds[0] == worlds[1]
    result = run(tmp_path / "tasks" / "take.yaml", robot="sim")
    assert result.status == "success", result


@pytest.mark.sim
def test_a_hand_put_on_an_arm_in_the_page_holds_something_too(tmp_path):
    """At the arm's own home these fingers are in the bench."""
    mount = "{link: tool0, root: rh_forearm, xyz: [0.0, 0.0, 0.01]}"
    (tmp_path / "grip.yaml").write_text(f"grip: 1\nrobot: {{arm: ur5, hand: shadow_right, mount: {mount}}}\n")
    begin(str(tmp_path), "", "", [])
    for task in ("first", "take"):
        result = run(tmp_path / "tasks" / f"{task}.yaml", robot="sim")
        assert result.status == "success", result


def test_fingers_without_shapes_take_nothing_and_the_project_is_written_all_the_same():
    robot = load_robot("ur5_gripper")
    urdf = ElementTree.fromstring(robot.urdf)
    fingers = {link for links in robot.finger_links.values() for link in links}
    for link in (each for each in urdf.iter("link") if each.get("name") in fingers):
        for shape in (*link.findall("collision"), *link.findall("visual")):
            link.remove(shape)
    assert first_grasp(replace(robot, urdf=ElementTree.tostring(urdf, "unicode")), str) == {}
