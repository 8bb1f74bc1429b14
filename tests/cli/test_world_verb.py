"""`grip world`: what it lists, shows, draws, checks and copies, and what it says of files that are wrong."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest

from grip_bt.cli.__main__ import main
from grip_sim.worlds import BUILTIN, load_world


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "grip.yaml").write_text("grip: 1\nrobot: panda_allegro\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_new_world_is_a_copy_that_is_listed_checked_and_shown(project, capsys):
    assert main(["world", "new", "mine", "--like", "shelf"]) == 0
    file = project / "worlds" / "mine.yaml"
    file.write_text(file.read_text().replace("A shelf of two boards", "My own shelf"))
    assert main(["world", "list"]) == 0
    listed = capsys.readouterr().out
    assert "mine: My own shelf" in listed
    assert all(f"{name}: " in listed for name in BUILTIN)
    assert main(["world", "check"]) == 0
    assert "1 world checked: 0 errors" in capsys.readouterr().out
    assert main(["world", "check", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"mine": []}
    assert main(["world", "show", "mine", "--seed", "3"]) == 0
    shown = capsys.readouterr().out
    assert "- name: upper\n  size: [0.28, 0.38, 0.28]\n" in shown
    assert "judge: {stored: in_upper == objects," in shown
    assert main(["world", "show", "mine", "--seed", "3", "--json"]) == 0
    spec = json.loads(capsys.readouterr().out)
    assert spec["robot"] == "panda_allegro"
    assert [thing["name"] for thing in spec["objects"]] == [thing.name for thing in load_world("shelf", 3).objects]


def test_what_is_there_is_left_alone_and_a_name_is_a_word(project, capsys):
    assert main(["world", "new", "mine"]) == 0
    before = (project / "worlds" / "mine.yaml").read_bytes()
    assert main(["world", "new", "mine", "--like", "shelf"]) == 1
    assert "is there already and was left alone" in capsys.readouterr().err
    assert (project / "worlds" / "mine.yaml").read_bytes() == before
    assert main(["world", "new", "../mine"]) == 1
    assert "use letters, digits" in capsys.readouterr().err
    assert main(["world", "new", "other", "--like", "shelv"]) == 1
    assert "did you mean 'shelf'" in capsys.readouterr().err
    assert not (project / "worlds" / "other.yaml").exists()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("draw: 2", "draw: 40", "40 objects 0.14 m apart don't fit"),
        ("in_upper ==", "in_uper ==", "unknown name 'in_uper'; did you mean 'in_upper'?"),
        ("radius: [0.028, 0.034]", "radius: -1", "radius"),
        ("regions:", "region:", "did you mean"),
    ],
)
def test_check_tells_what_is_wrong_and_so_does_the_check_of_the_project(project, capsys, old, new, told):
    assert main(["world", "new", "mine", "--like", "shelf"]) == 0
    file = project / "worlds" / "mine.yaml"
    assert old in file.read_text()
    file.write_text(file.read_text().replace(old, new, 1))
    capsys.readouterr()
    assert main(["world", "check"]) == 1
    said = capsys.readouterr().out
    assert told in said
    assert "1 error" in said


@pytest.mark.sim
def test_a_picture_shows_the_world_and_one_that_can_not_be_written_is_told_of(project, capsys):
    assert main(["world", "show", "shelf", "--picture", "shelf.png"]) == 0
    picture = cv2.imread(str(project / "shelf.png"))
    assert picture.shape == (240, 320, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    assert main(["world", "show", "shelf", "--picture", "nowhere/shelf.png"]) == 1
    assert "can't be written" in capsys.readouterr().err
    assert main(["world", "show", "shelf", "--camera", "frnt", "--picture", "a.png"]) == 1
    assert "did you mean 'front'" in capsys.readouterr().err
