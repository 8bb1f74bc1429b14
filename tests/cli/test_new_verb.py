"""`grip new` makes a project whose first task is right and runs."""

from xml.etree import ElementTree

import pytest

from grip_bt.cli.__main__ import main


def test_a_new_projects_first_task_is_valid_canonical_and_runs(tmp_path, capsys):
    folder = tmp_path / "lab"
    assert main(["new", str(folder)]) == 0
    assert f"grip run {folder}/tasks/first.yaml" in capsys.readouterr().out
    task = str(folder / "tasks" / "first.yaml")
    assert main(["check", task]) == 0
    assert main(["fmt", "--check", task]) == 0
    assert main(["run", task, "--robot", "fake"]) == 0
    assert (folder / ".gitignore").read_text().splitlines()[0] == ".grip/"


@pytest.mark.parametrize("existing", ["file", "folder"])
def test_nothing_is_written_where_something_is(tmp_path, capsys, existing):
    target = tmp_path / "lab"
    if existing == "file":
        target.write_text("mine")
    else:
        target.mkdir()
        (target / "notes.txt").write_text("mine")
    assert main(["new", str(target)]) == 1
    assert "is not an empty folder; nothing was written" in capsys.readouterr().err
    assert not (tmp_path / "lab" / "grip.yaml").exists()


def test_a_fresh_clone_counts_as_empty(tmp_path):
    (tmp_path / ".git").mkdir()
    assert main(["new", str(tmp_path)]) == 0


def test_a_new_ros_package_is_called_as_its_folder_and_runs(tmp_path, capsys):
    folder = tmp_path / "pick-Lab"
    assert main(["new", str(folder), "--ros"]) == 0
    package = ElementTree.parse(folder / "package.xml").getroot()
    assert (package.get("format"), package.findtext("name")) == ("3", "pick_lab")
    assert package.findtext("export/build_type") == "ament_python"
    assert (folder / "resource" / "pick_lab").read_bytes() == b""
    assert main(["run", str(folder / "tasks" / "first.yaml"), "--robot", "fake"]) == 0


@pytest.mark.parametrize("name", ["3d", "grüße", "a b"])
def test_a_folder_that_no_ros_package_can_be_called_as_is_refused(tmp_path, capsys, name):
    assert main(["new", str(tmp_path / name), "--ros"]) == 1
    assert "a ROS package is called as its folder" in capsys.readouterr().err
    assert not (tmp_path / name).exists()
