"""Runs as episodes of a LeRobot dataset: what is in the files is what the robot did, and a folder grows."""

import json

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.errors import GripError

pytest.importorskip("pyarrow.parquet")
from grip_bt.app.runs import export_lerobot

COUNT, NAMES = 12, ["shoulder", "finger"]


def film(file, size=(48, 64)):
    writer = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"mp4v"), export_lerobot.RATE, (size[1], size[0]))
    for k in range(COUNT):
        writer.write(np.full((*size, 3), 20 * k, np.uint8))
    writer.release()
    return file


def test_runs_become_episodes_of_one_dataset(tmp_path):
    films = {"wrist": film(tmp_path / "wrist.mp4")}
    joints = np.random.default_rng(3).normal(size=(2, COUNT, 2))
    for k, text in enumerate(("Lift it.", "Drop it.")):
        export_lerobot.add(tmp_path / "data", films, NAMES, joints[k], text, success=k == 0)
    data = tmp_path / "data"
    info = json.loads((data / "meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"]) == ("v3.0", export_lerobot.RATE)
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (2, 2 * COUNT, 2)
    assert info["features"]["observation.images.wrist"]["shape"] == [48, 64, 3]
    assert info["features"]["action"]["names"] == NAMES
    for k in range(2):
        where = {"chunk_index": 0, "file_index": k}
        rows = export_lerobot.parquet.read_table(data / info["data_path"].format(**where)).to_pydict()
        np.testing.assert_allclose(rows["observation.state"], joints[k], atol=1e-6)
        np.testing.assert_allclose(rows["action"][:-1], joints[k][1:], atol=1e-6)
        assert rows["index"] == list(range(k * COUNT, (k + 1) * COUNT))
        assert rows["next.success"] == [False] * (COUNT - 1) + [k == 0]
        assert rows["task_index"] == [k] * COUNT
        copied = data / info["video_path"].format(video_key="observation.images.wrist", **where)
        assert len(export_lerobot.frames_of(copied)) == COUNT
    stats = json.loads((data / "meta/stats.json").read_text())
    whole = joints.reshape(-1, 2)
    assert stats["observation.state"]["count"] == [2 * COUNT]
    np.testing.assert_allclose(stats["observation.state"]["std"], whole.std(axis=0), rtol=1e-5)
    with pytest.raises(GripError, match="other joints or cameras"):
        export_lerobot.add(data, films, ["shoulder", "thumb"], joints[0], "Lift it.", success=True)
    assert json.loads((data / "meta/info.json").read_text()) == info


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_statistics_of_two_samples_are_those_of_both(one, two, seed):
    rows = np.random.default_rng(seed).normal(size=(one + two, 3))
    both = export_lerobot._together(*(export_lerobot._statistics(part) for part in (rows[:one], rows[one:])))
    for name, value in export_lerobot._statistics(rows).items():
        np.testing.assert_allclose(both[name], value, atol=1e-9)


def test_joints_between_two_looks_are_interpolated():
    watch = object.__new__(export_lerobot.Watch)
    watch._rows = [(2.0, np.array([0.0, 1.0])), (2.03, np.array([0.3, 1.0])), (2.2, np.array([2.0, 0.0]))]
    frames = watch.frames()
    assert len(frames) == 6
    np.testing.assert_allclose(frames[:, 0], 10 * np.arange(6) / export_lerobot.RATE, atol=1e-9)
