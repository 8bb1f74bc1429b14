"""`grip sim`: what can't be served is said before anything starts."""

import pytest

from grip_bt.cli.__main__ import main

ROBOT = "grip: 1\nrobot: panda_allegro\narms: {right: {group: arm}}\n"


@pytest.mark.parametrize(
    ("project", "world", "words"),
    [
        (ROBOT, "tabel", "unknown world 'tabel'; did you mean 'table'?"),
        ("grip: 1\n", "table", "name one in grip.yaml: `robot: panda_allegro`"),
        (
            ROBOT + "ros: {controllers: {right: {positions: /commands}}}\n",
            "table",
            "ros/controllers/right: only `trajectory` and `gripper` controllers are simulated",
        ),
    ],
)
def test_what_cannot_be_served_is_said(tmp_path, capsys, project, world, words):
    (tmp_path / "grip.yaml").write_text(project)
    assert main(["sim", world, "--project", str(tmp_path)]) == 1
    assert words in capsys.readouterr().err
