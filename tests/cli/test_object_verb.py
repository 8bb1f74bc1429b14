"""`grip object`: what it lists and shows, brings in, and says of files that are wrong."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
import trimesh

from grip_bt.cli.__main__ import main
from grip_sim.objects import BUILTIN


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "grip.yaml").write_text("grip: 1\nrobot: panda_allegro\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_library_is_listed_and_shown(project, capsys):
    assert main(["object", "list"]) == 0
    listed = capsys.readouterr().out
    assert all(f"{name}: " in listed for name in BUILTIN)
    assert main(["object", "show", "mug"]) == 0
    assert "mass: 0.28\nfriction: 0.45" in capsys.readouterr().out
    assert main(["object", "show", "mug", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mass"] == 0.28
    assert main(["object", "show", "mugg"]) == 1
    assert "did you mean 'mug'" in capsys.readouterr().err


def test_a_mesh_becomes_an_object_that_worlds_take(project, capsys):
    trimesh.creation.cylinder(30, 100).export(project / "tea-can.stl")
    assert main(["object", "add", "tea-can.stl", "--mass", "0.2"]) == 0
    said = capsys.readouterr().out
    assert "tea_can: it is convex" in said
    assert "size: [0.06, 0.06, 0.1]" in said
    assert main(["object", "check"]) == 0
    assert "1 object checked: 0 errors" in capsys.readouterr().out
    assert main(["world", "new", "mine"]) == 0
    (project / "worlds" / "mine.yaml").write_text("grip: 1\nobjects: {it: {model: tea_can, at: [0.5, 0, 0]}}\n")
    assert main(["world", "show", "mine"]) == 0
    assert "- name: it\n  shape: model\n  radius: 0.03\n  height: 0.1\n" in capsys.readouterr().out
    (project / "objects" / "tea_can.yaml").write_text("grip: 1\nmass: 0.2\nsolids: []\n")
    assert main(["object", "check"]) == 1
    assert "either `solids` or a `mesh`" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere.stl"], "there is no such file or folder"),
        (["a.stl", "--name", "a b"], "can't be an object's name"),
    ],
)
def test_what_cannot_be_added_is_said(project, capsys, words, told):
    trimesh.creation.box((0.05, 0.05, 0.05)).export(project / "a.stl")
    assert main(["object", "add", *words]) == 1
    assert told in capsys.readouterr().err
    assert not (project / "objects").exists()


@pytest.mark.parametrize(
    ("option", "value"), [("--mass", "-1"), ("--scale", "inf"), ("--friction", "0"), ("--parts", "0")]
)
def test_a_number_that_no_object_can_have_is_a_mistake_in_usage(project, capsys, option, value):
    with pytest.raises(SystemExit) as ended:
        main(["object", "add", "a.stl", option, value])
    assert ended.value.code == 2
    assert f"argument {option}: '{value}' isn't a" in capsys.readouterr().err
    assert not (project / "objects").exists()


@pytest.mark.sim
def test_a_picture_shows_it_on_a_table(project):
    assert main(["object", "show", "tennis_ball", "--picture", "ball.png"]) == 0
    image = cv2.imread("ball.png").astype(int)
    green = (image[:, :, 1] > image[:, :, 0] + 60) & (image[:, :, 2] > image[:, :, 0] + 60)
    assert 0.01 < np.mean(green) < 0.5
