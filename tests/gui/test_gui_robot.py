"""The robot in space: what it looks like, how a run has moved it, and both in a browser."""

from __future__ import annotations

import json
import subprocess
from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi import FastAPI
from played import TASK, TestClient
from test_gui_e2e import SCENARIO, browser, editing

from grip_bt.app.runs.motion_record import FINE, Bodies, coarse, motion_file
from grip_bt.base.message_store.library import MessageLibrary
from grip_bt.base.value_codec import snapshot
from grip_bt.base.values import Grasp, JointState, PointCloud, Pose
from grip_bt.base.values.solids import CellMap, Mesh
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.runtime import Journal
from grip_bt.runtime.journal import DetailedEvent
from grip_gui.live.ros_client import RosClientProcess
from grip_gui.live.routes import last_state, make_live_router, motion_of
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.setup.robot_drawing import geometry

GRIP = "grip: 1\nrobot: panda_allegro\narms: {right: {group: arm, hand: palm}}\nhands: {palm: {group: hand}}\n"
BEGAN = 9.5
"""What the run's clock says when the run begins [s]: a simulator took that long to start."""
CUP = {"kind": "cylinder", "size": [0.04, 0.12], "fixed": False}
WEDGE = Mesh([(0, 0, 0), (0.2, 0, 0), (0, 0.2, 0), (0, 0, 0.3)])
CELLS = CellMap([(0, 0, 0), (1, 0, 0), (1, 1, 2)], 0.03)
CLOUD = PointCloud(np.random.default_rng(5).uniform((0.3, -0.3, 0), (0.7, 0.3, 0.02), (600, 3)).astype(np.float32))
TABLE = {"kind": "box", "size": [0.8, 1.2, 0.02], "at": [0.5, 0, -0.01, 1, 0, 0, 0], "hand": "", "fixed": True}


def recorded(folder: Path) -> tuple[str, list[list[float]]]:
    """Write a run that moves, grasps and chooses; return its id, and where the grasp frame was first and last."""
    description = build_robot("panda_allegro")
    model = RobotModel(description)
    arm, hand = description.groups["arm"], description.groups["hand"]
    turns = [[0.0, -0.4, 0.0, -2.0, 0.0, 1.6, 0.8], [0.4, 0.2, -0.3, -1.6, 0.1, 1.9, 0.2]]
    wanted = [model.grasp_pose(JointState(arm, turn)).position.tolist() for turn in turns]
    with Journal(folder / ".grip" / "runs.sqlite") as journal:
        log = journal.begin("tiny", "tasks/tiny.yaml", TASK, "bt", 7)
        log.append(BEGAN, "/", "run_started", None, None, {})
        log.append(BEGAN, "first", "enter", None, None, {})
        at = Pose((0.5, 0.1, 0.2))
        grasp = Grasp(at, at.moved((0, 0, 0.1)), at.moved((0, 0, 0.2)))
        data = {"variable": "chosen", "type": "Grasp", "preview": "a grasp"}
        log.note(BEGAN + 2.0, "first", DetailedEvent("write", data=data, written=(snapshot(grasp),)))
        data = {"variable": "cloud", "type": "PointCloud", "preview": "a cloud"}
        log.note(BEGAN + 2.1, "first", DetailedEvent("write", data=data, written=(snapshot(CLOUD),)))
        log.append(BEGAN + 3.0, "/", "run_ended", None, None, {"status": "success"})
        log.end("success", None)
    bodies = Bodies()
    odd = {
        "wedge": {**bodies.shape(WEDGE), "at": [0.6, -0.4, 0, 1, 0, 0, 0], "hand": "", "fixed": False},
        "seen": {**bodies.shape(CELLS), "at": [0.4, 0.4, 0, 1, 0, 0, 0], "hand": "", "fixed": False},
    }
    lines: list[dict[str, Any]] = [
        {"parts": {"palm": list(hand), "right": list(arm)}},
        {
            "t": BEGAN,
            "q": {"palm": [0.0] * len(hand), "right": turns[0]},
            "scene": {"table": TABLE, "cup": {**CUP, "at": [0.5, 0.1, 0.06, 1, 0, 0, 0], "hand": ""}},
        },
        {"t": BEGAN + 1.0, "plans": {"right": [turns]}},
        {"t": BEGAN + 2.0, "q": {"right": turns[1]}},
        {"t": BEGAN + 2.05, "plans": {"right": []}, "way": {"right": turns}},
        {
            "t": BEGAN + 2.5,
            "scene": {"table": TABLE, "cup": {**CUP, "at": [0, 0, 0.05, 1, 0, 0, 0], "hand": "palm"}, **odd},
            "way": {"right": []},
            "touch": {"palm": {"hand_link_3.0_tip": 5.0}},
            "press": {"palm": [["hand_link_3.0_tip", "cup", [0.5, 0.1, 0.3 + z], [0, 2.5, 0]] for z in (0.0, 0.02)]},
            "bodies": bodies.new(),
        },
    ]
    file = motion_file(folder / ".grip" / "runs.sqlite", log.id)
    file.parent.mkdir(parents=True)
    file.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return log.id, wanted


def test_a_robot_is_told_with_its_joints_and_few_triangles(tmp_path: Path) -> None:
    found = geometry("panda_allegro", {"palm": "arm"}, tmp_path)
    joints = {joint["name"]: joint for joint in found["joints"]}
    assert joints["panda_joint4"]["parent"] == "panda_link3"
    assert found["grasp"]["palm"]["link"] == "hand_palm_link"
    points = np.frombuffer(b64decode(found["meshes"][0]["points"]), "<f4").reshape(-1, 3)
    triangles = np.frombuffer(b64decode(found["meshes"][0]["triangles"]), "<u4").reshape(-1, 3)
    assert triangles.max() < len(points)
    size = sum(len(mesh["points"]) + len(mesh["triangles"]) for mesh in found["meshes"])
    assert size < 2_000_000  # of 5 MB as they come


def test_a_coarse_mesh_is_where_the_fine_one_is() -> None:
    turns = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rows = np.linspace(-1, 1, 100)
    points = np.array([(np.cos(a), np.sin(a), z) for z in rows for a in turns])
    number = np.arange(len(points)).reshape(100, 400)
    here, right = number[:-1], np.roll(number, -1, axis=1)[:-1]
    above = number[1:]
    triangles = np.stack([here, right, above], axis=-1).reshape(-1, 3)
    assert len(triangles) > FINE
    fewer, kept = coarse(points, triangles)
    assert 0 < len(kept) < len(triangles) / 2
    assert np.abs(np.hypot(fewer[:, 0], fewer[:, 1]) - 1).max() < 0.01
    assert np.allclose(np.ptp(fewer, axis=0), np.ptp(points, axis=0), atol=0.06)


def test_a_project_without_a_robot_says_so(page: TestClient) -> None:
    view = page.get("/api/live/geometry").json()
    assert view["error"] == "grip.yaml names no robot"


def test_the_record_of_a_motion_is_read_piece_by_piece(project: Path) -> None:
    run, _ = recorded(project)
    journal = project / ".grip" / "runs.sqlite"
    piece = motion_of(journal, run, 0)
    assert [sample.t for sample in piece.samples] == [BEGAN + t for t in (0.0, 1.0, 2.0, 2.05, 2.5)]
    with motion_file(journal, run).open("a") as record:
        record.write('{"t": 3.0, "q": {"right": [1')  # the writer is in the middle of a line
    assert motion_of(journal, run, piece.next).samples == []
    with motion_file(journal, run).open("a") as record:
        record.write(", 2, 3, 4, 5, 6, 7]}}\n")
    assert [sample.t for sample in motion_of(journal, run, piece.next).samples] == [3.0]
    assert last_state(journal, run, "right")["panda_joint7"] == 7
    assert last_state(journal, run, "left") == {}


@pytest.mark.parametrize("run", ["../../secret", "a/b", "", "a\x00"])
def test_no_other_file_is_read_as_a_motion(page: TestClient, run: str) -> None:
    assert page.get("/api/live/motion", params={"run": run}).status_code == 422


def test_a_run_without_a_record_has_no_motion(page: TestClient) -> None:
    assert page.get("/api/live/motion", params={"run": "20261121-1"}).json() == {
        "parts": {},
        "bodies": {},
        "samples": [],
        "next": 0,
    }


def test_a_robot_is_measured_by_the_run_only_while_one_is_under_way(page: TestClient, project: Path) -> None:
    (project / "grip.yaml").write_text(GRIP)
    recorded(project)
    request = {"robot": "run", "part": "right", "what": "joints", "name": "there"}
    assert page.post("/api/live/measure", json=request).json()["error"] == "no current run has measured right"


def test_where_a_run_under_way_has_brought_an_arm_is_kept_as_joints_and_as_a_pose(project: Path) -> None:
    (project / "grip.yaml").write_text(GRIP)
    run, wanted = recorded(project)
    app, folder = FastAPI(), ProjectFolder(project)
    app.include_router(make_live_router(folder, CommandRunner(project), RosClientProcess(project), lambda: run))
    client = TestClient(app)
    for what, part in (
        ("joints", "right"),
        ("pose", "right"),
        ("joints", "palm"),
        ("pose", "palm"),
        ("joints", "left"),
    ):
        request = {"robot": "run", "part": part, "what": what, "name": f"{part}_{what}", "serve": False}
        done = client.post("/api/live/measure", json=request).json()
        said = {"palm_pose": "palm is a hand", "left_joints": "no current run has measured left"}
        assert said.get(f"{part}_{what}", "") in done["error"]
        assert bool(done["error"]) == (f"{part}_{what}" in said)
    library = MessageLibrary(project / "messages")
    assert library.store("joint_states").get("right_joints").position[0] == pytest.approx(0.4)
    assert len(library.store("joint_states").get("palm_joints").names) == 16
    assert library.store("poses").get("right_pose").position == pytest.approx(wanted[1], abs=1e-6)


@pytest.mark.e2e
@pytest.mark.slow
def test_the_robot_is_drawn_where_it_was_at_each_moment_of_a_run(project: Path) -> None:
    (project / "grip.yaml").write_text(GRIP)
    run, wanted = recorded(project)
    with editing(project) as (_, url):
        command = browser("robot.mjs", url, run, json.dumps(wanted))
        done = subprocess.run(command, capture_output=True, text=True, timeout=SCENARIO)
        assert done.returncode == 0, done.stdout + done.stderr
