"""`grip new` makes a project whose first task is right and runs."""

from io import StringIO
from xml.etree import ElementTree

import pytest

from grip_bt.cli.__main__ import main


def test_a_new_projects_first_task_is_valid_canonical_and_runs(tmp_path, capsys):
    folder = tmp_path / "lab"
    assert main(["new", str(folder)]) == 0
    assert f"grip run {folder}/tasks/take.yaml" in capsys.readouterr().out
    for task in (str(folder / "tasks" / name) for name in ("first.yaml", "take.yaml")):
        assert main(["check", "--strict", task]) == 0
        assert main(["fmt", "--check", task]) == 0
        assert main(["run", task, "--robot", "fake"]) == 0
    assert main(["world", "check", str(folder / "worlds" / "bench.yaml")]) == 0
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
    assert "a ROS package has the name of its folder" in capsys.readouterr().err
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("\n\n", ("robot: panda_allegro", "world: bench")),
        ("\nshelf\n", ("robot: panda_allegro", "world: shelf")),
        ("allegro_left\nempty\n", ("robot: allegro_left", "world: empty")),
    ],
)
def test_at_a_terminal_the_robot_and_the_world_are_asked_for(tmp_path, capsys, monkeypatch, typed, said):
    monkeypatch.setattr("sys.stdin", terminal := StringIO(typed))
    terminal.isatty = lambda: True
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    assert main(["new", str(tmp_path / "lab")]) == 0
    lines = (tmp_path / "lab" / "grip.yaml").read_text().splitlines()
    assert set(said) <= set(lines)
    assert main(["check", "--strict", str(tmp_path / "lab")]) == 0
    assert (tmp_path / "lab" / "tasks" / "take.yaml").exists() == (said[1] == "world: bench")


def test_a_world_that_isnt_there_is_refused_before_anything_is_written(tmp_path, capsys):
    assert main(["new", str(tmp_path / "lab"), "--world", "tabel"]) == 1
    assert "unknown world 'tabel'; did you mean 'table'" in capsys.readouterr().err
    assert not (tmp_path / "lab").exists()


def test_a_robots_name_is_looked_up_before_a_folder_that_happens_to_be_called_so(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("sim", "panda"):
        (tmp_path / name).mkdir()
    assert main(["new", "unknown", "--robot", "sim"]) == 1
    said = capsys.readouterr().err
    assert f"{tmp_path / 'sim'} holds none, and none is ready-made: unknown robot 'sim'" in said
    assert "panda_allegro" in said
    assert main(["new", "lab", "--robot", "panda"]) == 0
    assert "\nrobot: panda\n" in (tmp_path / "lab" / "grip.yaml").read_text()
    capsys.readouterr()
    assert main(["new", "other", "--robot", "./panda"]) == 1
    assert "there is no MoveIt configuration package in it" in capsys.readouterr().err
