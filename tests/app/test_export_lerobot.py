"""Runs as episodes of a LeRobot dataset: what is in the files is what the simulator did, and a folder grows."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.export import export_run
from grip_bt.base.errors import GripError
from grip_bt.runtime import JournalReader
from grip_sim.cameras.rig import RATE

pytestmark = [pytest.mark.sim, pytest.mark.slow]
PROJECT = """grip: 1
robot: panda
arms: {panda: {group: arm, hand: gripper}}
hands: {gripper: {group: hand}}
world: small
"""
WORLD = """grip: 1
fixtures: {table: {box: [0.7, 1.2, 0.1], at: [0.65, 0, -0.1]}}
objects: {cube: {model: cube, at: [0.5, 0.2, 0]}}
cameras:
  front: {at: [1.5, 0.5, 0.8], look_at: [0.4, 0, 0.2], width: 80, height: 60}
  wrist: {link: panda_hand, at: [0.07, 0, 0.03], quaternion: [1, 0, 0, 0], width: 64, height: 48}
"""
TASK = """grip: 1
name: wave
doc: Lift the hand a little.
root: {node: arm/move_straight, with: {offset: [0.0, 0.0, 0.05]}}
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A task's file, its journal, and a run that was recorded while it went on, with the folder of that."""
    folder = tmp_path_factory.mktemp("project")
    for name, text in {"grip.yaml": PROJECT, "worlds/small.yaml": WORLD, "tasks/wave.yaml": TASK}.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    task, options = folder / "tasks/wave.yaml", RunOptions(seed=2)
    with open_session(task, options) as session, session.resources.world.recorded(folder):
        before = session.resources.arms["panda"].state()
        assert session.runner.run().status == "success"
        after = session.resources.arms["panda"].state()
    return task, session.journal, session.runner.run_id, folder, before, after


def test_a_record_has_a_row_for_each_frame_of_each_film(runs):
    *_, folder, before, after = runs
    joints = np.load(folder / "joints.npz")
    names = joints["names"].tolist()
    columns = [names.index(name) for name in before.names]
    np.testing.assert_allclose(joints["positions"][0, columns], before.position, atol=1e-3)
    np.testing.assert_allclose(joints["positions"][-1, columns], after.position, atol=0.02)
    assert joints["targets"].shape == joints["positions"].shape
    for film in ("front", "wrist"):
        assert cv2.VideoCapture(str(folder / f"{film}.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == len(joints["positions"])


def test_runs_become_episodes_of_one_dataset(runs, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    task, journal, run, folder, *_ = runs
    joints = np.load(folder / "joints.npz")
    count = len(joints["positions"])
    with JournalReader(journal) as reader:
        for _ in range(2):
            export_run(reader, run, tmp_path / "data", "lerobot")
    info = json.loads((tmp_path / "data/meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", RATE, 2)
    assert info["total_frames"] == 2 * count
    assert info["features"]["observation.images.front"]["shape"] == [60, 80, 3]
    for episode in range(2):
        where = {"chunk_index": 0, "file_index": episode}
        rows = parquet.read_table(tmp_path / "data" / info["data_path"].format(**where)).to_pydict()
        np.testing.assert_allclose(rows["observation.state"], joints["positions"], atol=1e-6)
        np.testing.assert_allclose(rows["action"], joints["targets"], atol=1e-6)
        assert rows["index"] == list(range(episode * count, (episode + 1) * count))
        assert rows["next.success"] == [False] * (count - 1) + [True]
        film = tmp_path / "data" / info["video_path"].format(video_key="observation.images.wrist", **where)
        assert cv2.VideoCapture(str(film)).get(cv2.CAP_PROP_FRAME_COUNT) == count
    told = [
        parquet.read_table(file).to_pylist()[0] for file in sorted((tmp_path / "data/meta/episodes").rglob("*.parquet"))
    ]
    assert [(e["dataset_from_index"], e["dataset_to_index"], e["tasks"]) for e in told] == [
        (0, count, ["Lift the hand a little."]),
        (count, 2 * count, ["Lift the hand a little."]),
    ]
    stats = json.loads((tmp_path / "data/meta/stats.json").read_text())
    assert stats["action"]["count"] == [2 * count]
    np.testing.assert_allclose(stats["action"]["mean"], joints["targets"].mean(axis=0), atol=1e-6)
    np.testing.assert_allclose(stats["action"]["std"], joints["targets"].std(axis=0), atol=1e-6)


def test_what_cannot_be_filmed_any_more_is_refused(runs, tmp_path):
    pytest.importorskip("pyarrow")
    task, journal, run, *_ = runs
    with open_session(task, RunOptions(robot="fake", journal=tmp_path / "fake.sqlite")) as session:
        session.runner.run()
    with (
        JournalReader(tmp_path / "fake.sqlite") as reader,
        pytest.raises(GripError, match="isn't one of a simulated robot"),
    ):
        export_run(reader, session.runner.run_id, tmp_path / "no", "lerobot")
    task.write_text(TASK.replace("0.05", "0.06"))
    with JournalReader(journal) as reader, pytest.raises(GripError, match=f"{Path(task).name} has changed"):
        export_run(reader, run, tmp_path / "no", "lerobot")
    assert not (tmp_path / "no").exists()
