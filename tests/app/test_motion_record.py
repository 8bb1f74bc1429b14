"""The record of a run's motion: what has changed, in order, to the end."""

from __future__ import annotations

import json
import threading
from pathlib import Path

from grip_bt.app.motion_record import KEPT, motion_file, recorded_motion
from grip_bt.app.resources import Resources
from grip_bt.commanders.fake import FakeArm
from grip_bt.commanders.scene import PlanningScene
from grip_bt.errors import SimulatorLostError
from grip_bt.runtime import WallClock
from grip_bt.values import JointState, Pose


class Turning:
    """An arm that has turned a little further whenever it is asked; `asked` is set at the third time."""

    def __init__(self) -> None:
        self.angle, self.times, self.asked = 0.0, 0, threading.Event()

    def state(self) -> JointState:
        self.times, self.angle = self.times + 1, self.angle + 0.25
        if self.times == 3:
            self.asked.set()
        return JointState(("shoulder",), [self.angle])


def lines(file: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in file.read_text().splitlines()]


def test_positions_and_the_scene_are_told_as_they_change_and_once_more_at_the_end(tmp_path: Path) -> None:
    arm = Turning()
    scene = PlanningScene({"palm": lambda: Pose((0, 0, 0))}, {"crate": ((0.2, 0.2, 0.1), Pose((0.5, 0.0, 0.05)))})
    with recorded_motion(Resources(arms={"right": arm}, scene=scene), WallClock(), tmp_path / "runs.sqlite", "one"):
        assert arm.asked.wait(20)
        scene.set_box("cup", (0.1, 0.1, 0.2), Pose((0.3, 0.0, 0.1)))
    header, first, *rest = lines(motion_file(tmp_path / "runs.sqlite", "one"))
    assert header == {"parts": {"right": ["shoulder"]}}
    assert list(first["scene"]) == ["crate"]
    assert first["scene"]["crate"]["size"] == [0.2, 0.2, 0.1]
    angles = [line["q"]["right"][0] for line in (first, *rest)]
    assert angles == sorted(set(angles))
    assert [list(line["scene"]) for line in rest if "scene" in line][-1] == ["crate", "cup"]


def test_what_stands_still_is_told_once(tmp_path: Path) -> None:
    arm = FakeArm("right")
    with recorded_motion(Resources(arms={"right": arm}), WallClock(), tmp_path / "runs.sqlite", "one"):
        pass
    assert len(lines(motion_file(tmp_path / "runs.sqlite", "one"))) == 2


def test_without_a_robot_there_is_no_record(tmp_path: Path) -> None:
    with recorded_motion(Resources(), WallClock(), tmp_path / "runs.sqlite", "one"):
        pass
    assert not (tmp_path / "motion").exists()


def test_a_robot_that_is_lost_ends_the_record_and_not_the_run(tmp_path: Path) -> None:
    class Lost:
        def state(self) -> JointState:
            raise SimulatorLostError("gone")

    with recorded_motion(Resources(arms={"right": Lost()}), WallClock(), tmp_path / "runs.sqlite", "one"):
        pass
    assert lines(motion_file(tmp_path / "runs.sqlite", "one")) == []


def test_records_of_the_latest_runs_are_kept(tmp_path: Path) -> None:
    for number in range(KEPT + 3):
        with recorded_motion(Resources(arms={"right": FakeArm("right")}), WallClock(), tmp_path / "j", f"run{number}"):
            pass
    assert len(list((tmp_path / "motion").glob("*.jsonl"))) <= KEPT + 1
