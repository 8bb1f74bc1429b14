"""One protocol starts every robot that a run may get: what it gives, and what it refuses before anything starts."""

from __future__ import annotations

from contextlib import ExitStack

import pytest

from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring.open import BACKENDS, backend_of
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.errors import UnknownNameError

PROJECT = """grip: 1
robot: panda_allegro
world: table
arms: {right: {group: arm, hand: right_hand}}
hands: {right_hand: {group: hand}}
sensors: {head: {camera: overhead}}
ros: {controllers: {right: {trajectory: /a}, right_hand: {trajectory: /b}}}
"""


def write(folder, text):
    (folder / "grip.yaml").write_text(text)
    return find_project(folder)


@pytest.mark.parametrize("robot", ["fake", "sim"])
def test_it_gives_every_arm_hand_and_camera_and_can_be_started_again(tmp_path, robot):
    project, backend = write(tmp_path, PROJECT), backend_of(robot)
    for _ in range(2 if robot == "fake" else 1):
        with ExitStack() as stack:
            parts = backend(Opening(project), stack)
            assert (list(parts.arms), list(parts.hands), list(parts.cameras)) == (["right"], ["right_hand"], ["head"])
            assert parts.scene is not None
            assert parts.arms["right"].state().names
            assert bool(parts.pausable) == (robot != "fake"), "what fakes do is done at once"
            assert (parts.world is None) == (robot == "fake") == (parts.fakes is not None)


@pytest.mark.parametrize("robot", sorted(set(BACKENDS) - {"fake"}))
def test_a_group_that_is_not_there_is_refused_before_a_robot_is_started(tmp_path, robot):
    project = write(tmp_path, PROJECT.replace("group: arm", "group: amr"))
    told: list[str] = []
    with ExitStack() as stack, pytest.raises(UnknownNameError, match="group 'amr'"):
        backend_of(robot)(Opening(project, progress=lambda part, words: told.append(part)), stack)
    assert not {"simulator", "planner", "robot"} & set(told)


def test_an_unknown_robot_is_named_with_those_that_there_are():
    with pytest.raises(UnknownNameError, match="fake"):
        backend_of("fkae")
