"""A project is found from any of its files, and a wrong `grip.yaml` says where and what."""

from pathlib import Path

import pytest

from grip_bt.app.project.catalogue import catalogue_of, project_catalog
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def test_a_task_file_finds_its_project():
    project = find_project(EXAMPLES / "tasks" / "reactive_pick.yaml")
    assert project.folder == EXAMPLES
    assert project.file.arms["right"].hand == "right_hand"


def test_the_catalogue_holds_builtin_sensor_and_component_nodes():
    ids = project_catalog(EXAMPLES / "tasks" / "reactive_pick.yaml").ids()
    assert {"arm/lift", "sensor/overhead", "component/antipodal_grasps"} <= set(ids)


def test_without_a_project_file_only_builtin_nodes_exist(tmp_path):
    project = find_project(tmp_path / "task.yaml")
    assert project.folder == tmp_path
    assert "flow/wait" in catalogue_of(project).ids()
    assert not any(i.startswith("sensor/") for i in catalogue_of(project).ids())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("grip: 1\nrobt: a\n", r"grip.yaml:2:1: unknown key 'robt' in the file; did you mean 'robot'\?"),
        ("grip: 1\narms: {a: {sped: 1}}\n", r":2:12: unknown key 'sped' in arms/a; did you mean 'speed'\?"),
        ("grip: 1\narms: {a: {speed: 2}}\n", r":2:12: arms/a/speed: .* less than or equal to 1, not 2"),
        ("- a\n", "a mapping with grip, doc, robot"),
        ("grip: 2\n", "grip: Input should be 1, not 2"),
        ("grip: 1\narms: {'a b': {}}\n", "'a b' isn't a name"),
    ],
)
def test_a_wrong_project_file_says_where_and_what(tmp_path, text, message):
    (tmp_path / "grip.yaml").write_text(text)
    with pytest.raises(DocumentError, match=message):
        find_project(tmp_path)


def test_a_robot_that_is_a_file_is_named_by_its_path_wherever_one_stands(tmp_path, monkeypatch):
    """The simulator and the planner load it in processes of their own."""
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "arm.urdf").write_text("<robot name='arm'/>")
    monkeypatch.chdir("/")
    for said, named in (("robots/arm.urdf", str(tmp_path / "robots" / "arm.urdf")), ("panda", "panda")):
        (tmp_path / "grip.yaml").write_text(f"grip: 1\nrobot: {said}\n")
        assert find_project(tmp_path / "task.yaml").robot_source == named
