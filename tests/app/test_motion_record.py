"""The record of a run's motion: what has changed, in order, to the end."""

from __future__ import annotations

import json
import threading
from base64 import b64decode
from pathlib import Path

import numpy as np

from grip_bt.app.runs.motion_record import KEPT, MOST_CELLS, Bodies, few_cells, motion_file, recorded_motion
from grip_bt.app.wiring.parts import Resources
from grip_bt.base.errors import SimulatorLostError
from grip_bt.base.ports import Ways
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.base.values.joints import ContactPoint
from grip_bt.base.values.solids import CellMap, Mesh
from grip_bt.commanders.fake import FakeArm, FakeHand
from grip_bt.commanders.scene import PlanningScene
from grip_bt.runtime import WallClock


class Turning:
    ways = Ways()

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
        assert arm.asked.wait(120)
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


def test_the_way_of_a_motion_and_what_touches_are_told_once_each(tmp_path: Path) -> None:
    class Gripping(FakeHand):
        def contacts(self) -> dict[str, float]:
            return {"tip": 2.04}

    arm, hand = FakeArm("right"), Gripping(JointState(("finger",), [0.0]))
    joints = tuple(reversed(arm.state().names))
    arm.ways = Ways(Trajectory(joints, np.array([0.0, 2.0]), np.array([range(len(joints)), [1.0] * len(joints)])))
    with recorded_motion(Resources(arms={"right": arm}, hands={"hand": hand}), WallClock(), tmp_path / "j", "one"):
        pass
    _, first, *_ = lines(motion_file(tmp_path / "j", "one"))  # a second line says that the motion is over
    assert first["touch"] == {"hand": {"tip": 2.0}}
    way = np.array(first["way"]["right"])
    assert way.shape[1] == len(joints)
    assert way[0].tolist() == [float(joints.index(joint)) for joint in arm.state().names]
    assert way[-1].tolist() == [1.0] * len(joints)


def test_a_motion_is_planned_begun_and_over_and_contacts_have_points(tmp_path: Path) -> None:
    class Planning:
        def __init__(self) -> None:
            self.ways, self.asked = Ways(), 0

        def state(self) -> JointState:
            self.asked += 1
            match self.asked:
                case 2:
                    self.ways = Ways(planned=(there, back))
                case 4:
                    self.ways = Ways(there, True, (back,))
                case 8:
                    self.ways = self.ways._replace(moving=False)
                    over.set()
            return JointState(("a",), [0.0])

    class Pressing(FakeHand):
        def contacts(self) -> dict[str, float]:
            return {"tip": 2.0}

        def contact_points(self) -> list[ContactPoint]:
            slight = ContactPoint("tip", "can", (0.0, 0.0, 0.0), (0.0, 0.01, 0.0))
            return [ContactPoint("tip", "can", (0.1, 0.2, 0.30001), (0.0, 0.0, 2.04)), slight]

    over = threading.Event()
    there, back = (
        Trajectory(("a",), np.array([0.0, 1.0]), np.array(rows)) for rows in ([[0.0], [1.0]], [[1.0], [0.0]])
    )
    arm, hand = Planning(), Pressing(JointState(("finger",), [0.0]))
    with recorded_motion(Resources(arms={"right": arm}, hands={"hand": hand}), WallClock(), tmp_path / "j", "one"):
        assert over.wait(120)
    _, *rest = lines(motion_file(tmp_path / "j", "one"))
    plans = [[(way[0], way[-1]) for way in line["plans"]["right"]] for line in rest if "plans" in line]
    assert plans == [[([0.0], [1.0]), ([1.0], [0.0])], [([1.0], [0.0])]]
    ways = [line["way"]["right"] for line in rest if "way" in line]
    assert [way and (way[0], way[-1]) for way in ways] == [([0.0], [1.0]), []]
    assert [line["press"] for line in rest if "press" in line] == [
        {"hand": [["tip", "can", [0.1, 0.2, 0.3], [0.0, 0.0, 2.0]]]}
    ]


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


CORNERS = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.1) for z in (0, 0.4)])


def decoded(body: dict[str, str]) -> tuple[np.ndarray, np.ndarray]:
    points = np.frombuffer(b64decode(body["points"]), "<f4").reshape(-1, 3)
    return points, np.frombuffer(b64decode(body["triangles"]), "<u4").reshape(-1, 3)


def test_meshes_and_cells_are_told_as_they_look_and_each_once(tmp_path: Path) -> None:
    arm = Turning()
    scene = PlanningScene({"palm": lambda: Pose((0, 0, 0))}, {})
    seen = CellMap(np.array([[0, 0, 0], [1, 0, 0], [5, 5, 5]]), 0.02)
    scene.put("seen", seen, Pose((0.1, 0.2, 0.3)))
    scene.put("wedge", Mesh(CORNERS), Pose((0.5, 0.0, 0.0)))
    with recorded_motion(Resources(arms={"right": arm}, scene=scene), WallClock(), tmp_path / "runs.sqlite", "one"):
        assert arm.asked.wait(120)
        scene.put("second", Mesh(CORNERS), Pose((0.8, 0.0, 0.0)))
    _, *rest = lines(motion_file(tmp_path / "runs.sqlite", "one"))
    bodies = {name: body for line in rest for name, body in line.get("bodies", {}).items()}
    assert sum(len(line.get("bodies", {})) for line in rest) == len(bodies) == 2
    last = [line["scene"] for line in rest if "scene" in line][-1]
    assert last["second"]["body"] == last["wedge"]["body"] != last["seen"]["body"]
    assert (last["seen"]["kind"], last["seen"]["size"]) == ("cells", [0.02])
    assert last["seen"]["at"][:3] == [0.1, 0.2, 0.3]
    middles, none = decoded(bodies[last["seen"]["body"]])
    assert np.allclose(middles, seen.middles(), atol=1e-6)
    assert len(none) == 0
    points, triangles = decoded(bodies[last["wedge"]["body"]])
    assert last["wedge"]["at"][:3] == [0.5, 0.0, 0.0]
    assert abs(volume(points, triangles) - 0.2 * 0.1 * 0.4) < 1e-6


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    """Return what a convex surface encloses: the tetrahedra from its middle to its triangles."""
    a, b, c = (points[triangles[:, corner]].astype(float) - points.mean(axis=0) for corner in range(3))
    return float(np.abs(np.einsum("ij,ij->i", a, np.cross(b, c))).sum() / 6)


def test_a_hull_with_a_margin_is_drawn_as_thick_as_it_is() -> None:
    bodies = Bodies()
    bodies.shape(Mesh(CORNERS, margin=0.01))
    ((points, _),) = (decoded(body) for body in bodies.new().values())
    assert np.allclose(np.ptp(points, axis=0), [0.22, 0.12, 0.42], atol=1e-6)
    assert bodies.new() == {}


def test_a_large_map_is_covered_by_few_larger_cells() -> None:
    rng = np.random.default_rng(3)
    fine = CellMap(rng.integers(-60, 60, (30_000, 3)), 0.01)
    few = few_cells(fine)
    assert len(few.cells) <= MOST_CELLS
    covering = {tuple(cell) for cell in few.cells.tolist()}
    assert all(tuple(cell) in covering for cell in np.floor(fine.middles() / few.resolution).astype(int).tolist())
