"""Exports of a run: what is read back from the file is what the journal has."""

from __future__ import annotations

import base64
import csv
import json
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from timed import ManualClock

from grip_bt.app.runs.export import COLUMNS, FORMATS, export_run
from grip_bt.app.runs.motion_record import motion_file
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import CameraInfo, DepthImage, Failure, Grasp, Image, PointCloud, Pose, RgbdFrame
from grip_bt.cli.__main__ import main
from grip_bt.runtime import Journal, JournalReader
from grip_bt.runtime.observers import Recorder

RNG = np.random.default_rng(4)
CLOUD = PointCloud(RNG.normal(size=(600, 3)), RNG.integers(0, 255, (600, 3), np.uint8), "camera")
IMAGE = Image(RNG.integers(0, 255, (12, 16, 3), np.uint8), "optical")
DEPTH = DepthImage(RNG.random((12, 16)).astype(np.float32), CameraInfo(16, 12, np.eye(3), Pose(frame="optical")))
POSE = Pose([1, 2, 3], [0.5, 0.5, -0.5, 0.5], "table")
VALUES = {
    "cloud": CLOUD,
    "frame": RgbdFrame(IMAGE, DEPTH),
    "pose": POSE,
    "grasps": [Grasp(POSE, POSE, POSE)] * 3,
    "count": 7,
    "odd": object(),
}


@pytest.fixture
def book(tmp_path: Path) -> tuple[Path, str]:
    """A project's journal with one run."""
    file = tmp_path / ".grip" / "runs.sqlite"
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("pick", "pick.yaml", "grip: 1"), clock := ManualClock())
        recorder.say("run_started")
        for name, value in VALUES.items():
            clock.advance(0.25)
            recorder.entered(f"écrit/{name}")
            recorder.wrote(f"écrit/{name}", name, "Any", value)
            recorder.ended(f"écrit/{name}", "success", None)
        recorder.ended("/", "failure", Failure("no_ik", 'a "quoted", long\nreason'))
        recorder.finished("failure", "failure")
    return file, log.id


def test_lines_and_tables_have_every_event(book: tuple[Path, str], tmp_path: Path) -> None:
    file, run = book
    with JournalReader(file) as reader:
        events = [json.loads(json.dumps(asdict(event))) for event in reader.events(run)]
        for to in ("jsonl", "csv"):
            assert export_run(reader, run, tmp_path / to, to) == len(events)
    lines = (tmp_path / "jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == events
    with (tmp_path / "csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    assert tuple(rows[0]) == COLUMNS
    for row, event in zip(rows, events, strict=True):
        assert (int(row["seq"]), float(row["t"]), float(row["wall"])) == (event["seq"], event["t"], event["wall"])
        assert [row[c] for c in ("path", "event")] == [event["path"], event["event"]]
        assert (row["outcome"] or None, row["code"] or None) == (event["outcome"], event["code"])
        assert json.loads(row["data"] or "{}") == event["data"]


def read_mcap(file: Path) -> dict[tuple[str, str], list[dict[str, Any]]]:
    found: dict[tuple[str, str], list[dict[str, Any]]] = {}
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            assert json.loads(schema.data)["type"] == "object"
            fields = json.loads(message.data)
            assert set(fields) <= set(json.loads(schema.data)["properties"])
            found.setdefault((channel.topic, schema.name), []).append(fields)
    return found


def test_a_recording_has_events_a_log_and_values_that_foxglove_draws(book: tuple[Path, str], tmp_path: Path) -> None:
    file, run = book
    with JournalReader(file) as reader:
        count = export_run(reader, run, tmp_path / "run.mcap", "mcap")
        events = [json.loads(json.dumps(asdict(event))) for event in reader.events(run)]
    found = read_mcap(tmp_path / "run.mcap")
    assert found["/grip/events", "grip.Event"] == events
    log = found["/grip/log", "foxglove.Log"]
    assert len(log) == count == len(events)
    assert (log[-2]["level"], log[-2]["message"]) == (3, 'exit failure (no_ik) a "quoted", long\nreason')
    (cloud,) = found["/grip/data/cloud", "foxglove.PointCloud"]
    packed = np.frombuffer(base64.b64decode(cloud["data"]), np.uint8).reshape(600, cloud["point_stride"])
    assert np.array_equal(packed[:, :12].copy().view("<f4"), CLOUD.points)
    assert CLOUD.colors is not None
    assert np.array_equal(packed[:, 12:15], CLOUD.colors)
    assert [field["offset"] for field in cloud["fields"]] == [0, 4, 8, 12, 13, 14, 15]
    (image,) = found["/grip/data/frame/image", "foxglove.RawImage"]
    assert (image["width"], image["height"], image["step"], image["encoding"]) == (16, 12, 48, "rgb8")
    assert base64.b64decode(image["data"]) == IMAGE.pixels.tobytes()
    (depth,) = found["/grip/data/frame/depth", "foxglove.RawImage"]
    assert (depth["step"], depth["encoding"], depth["frame_id"]) == (64, "32FC1", "optical")
    (pose,) = found["/grip/data/pose", "foxglove.PoseInFrame"]
    assert pose["pose"]["orientation"] == {"w": 0.5, "x": 0.5, "y": -0.5, "z": 0.5}
    assert (pose["pose"]["position"], pose["frame_id"]) == ({"x": 1, "y": 2, "z": 3}, "table")
    assert len(found["/grip/data/grasps", "foxglove.PosesInFrame"][0]["poses"]) == 3
    assert found["/grip/data/count", "grip.Value"] == [{"preview": "7", "value": 7}]
    assert found["/grip/data/odd", "grip.Value"][0]["preview"].startswith("<object object")


def test_unknown_formats_and_runs_are_named_with_those_that_exist(book: tuple[Path, str], tmp_path: Path) -> None:
    with JournalReader(book[0]) as reader:
        with pytest.raises(UnknownNameError, match="mcap"):
            export_run(reader, book[1], tmp_path / "x", "rosbag")
        with pytest.raises(UnknownNameError, match=book[1]):
            export_run(reader, "nope", tmp_path / "x", "csv")


@pytest.mark.parametrize("to", sorted({*FORMATS} - {"rerun"}))
def test_the_command_exports_a_run_by_id_beginning_or_last(
    to: str, book: tuple[Path, str], tmp_path: Path, capsys: Any
) -> None:
    for name in (book[1], book[1][:12], "last"):
        assert main(["runs", name, "--journal", str(book[0]), "--to", to, "-o", str(tmp_path / "out")]) == 0
        assert "21 events" in capsys.readouterr().out
    assert main(["runs", str(tmp_path), "--to", to, "-o", str(tmp_path / "out")]) == 0
    assert main(["runs", "nope", "--journal", str(book[0]), "--to", to, "-o", str(tmp_path / "out")]) == 1
    assert book[1] in capsys.readouterr().err


def test_a_recording_without_its_library_says_what_brings_it(
    book: tuple[Path, str], tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for to, module, extra in (("mcap", "mcap.writer", "recording"), ("rerun", "rerun", "rerun")):
        monkeypatch.setitem(sys.modules, module, None)
        assert main(["runs", "last", "--journal", str(book[0]), "--to", to, "-o", str(tmp_path / "out")]) == 1
        assert f"pip install 'grip-bt[{extra}]'" in capsys.readouterr().err


def test_a_rerun_recording_holds_what_was_written_and_where_nodes_were(book: tuple[Path, str], tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="its viewer is half a gigabyte; `make packaging` runs this with it")
    file = tmp_path / "run.rrd"
    assert main(["runs", "last", "--journal", str(book[0]), "--to", "rerun", "-o", str(file)]) == 0
    rerun = [sys.executable, "-m", "rerun_cli", "rrd"]
    assert subprocess.run([*rerun, "verify", file], capture_output=True).returncode == 0
    told = subprocess.run([*rerun, "stats", file], capture_output=True, text=True, check=True).stdout
    entities = {line.strip().partition(":")[0] for line in told.splitlines() if line.startswith("/")}
    assert {"/task", "/log", "/world", "/nodes/task", "/data/frame/image", "/data/frame/depth"} <= entities
    assert {"/world/data/cloud", "/world/data/pose", "/world/data/grasps", "/data/count"} <= entities


URDF = """<robot name="r"><link name="base"/><link name="tool"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="tool"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"""


def test_a_recording_draws_the_robot_and_the_scene_as_they_moved(
    book: tuple[Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, run = book
    (tmp_path / "r.urdf").write_text(URDF)
    (tmp_path / "grip.yaml").write_text("grip: 1\nrobot: r.urdf\n")
    here = {"at": [0.5, 0, 0.1, 1, 0, 0, 0], "hand": "", "fixed": False}
    points, triangles = np.eye(3, dtype="<f4"), np.array([0, 1, 2], "<u4")
    bodies = {"b": {"points": base64.b64encode(points).decode(), "triangles": base64.b64encode(triangles).decode()}}
    things = {
        "bin": {"kind": "box", "size": [0.1, 0.2, 0.3], **here},
        "can": {"kind": "cylinder", "size": [0.03, 0.1], **here},
        "mug": {"kind": "mesh", "size": [1, 1, 1], "body": "b", **here},
        "heap": {"kind": "cells", "size": [0.01], "body": "b", **here},
    }
    ball = {"ball": {"kind": "sphere", "size": [0.02], **here, "fixed": True}}
    lines = [{"parts": {"arm": ["turn"]}}, {"t": 0.25, "q": {"arm": [0.0]}, "scene": things, "bodies": bodies}]
    lines.append({"t": 0.5, "q": {"arm": [np.pi / 2]}, "scene": {"bin": things["bin"], **ball}})
    motion = motion_file(file, run)
    motion.parent.mkdir()
    motion.write_text("\n".join(map(json.dumps, lines)))
    with JournalReader(file) as reader:
        monkeypatch.chdir(tmp_path)  # where its task is
        export_run(reader, run, tmp_path / "run.mcap", "mcap")
    found = read_mcap(tmp_path / "run.mcap")
    assert "<robot" in found["/robot_description", "grip.Text"][0]["data"]
    first, second = found["/tf", "foxglove.FrameTransforms"]
    (tool,) = (each for each in second["transforms"] if each["child_frame_id"] == "tool")
    assert tool["translation"] == {"x": 0, "y": 0, "z": 0.5}
    assert tool["rotation"]["z"] == pytest.approx(np.sqrt(0.5))
    assert first["transforms"] != second["transforms"]
    before, after = found["/grip/scene", "foxglove.SceneUpdate"]
    parts = {
        each["id"]: {kind: each[kind] for kind in ("cubes", "cylinders", "triangles") if each[kind]}
        for each in before["entities"]
    }
    assert parts["bin"]["cubes"][0]["size"] == {"x": 0.1, "y": 0.2, "z": 0.3}
    assert parts["can"]["cylinders"][0]["size"] == {"x": 0.06, "y": 0.06, "z": 0.1}
    assert parts["mug"]["triangles"][0]["indices"] == [0, 1, 2]
    assert len(parts["heap"]["cubes"]) == 3
    assert [each["id"] for each in after["entities"]] == ["ball"]
    assert {each["id"] for each in after["deletions"]} == {"can", "mug", "heap"}


def test_the_command_shows_the_last_values(book: tuple[Path, str], capsys: Any) -> None:
    assert main(["runs", "last", "--journal", str(book[0]), "--data"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(VALUES)
    assert "PointCloud(600 points, frame='camera')  (by écrit/cloud, 0.250 s)" in lines[0]
    assert main(["runs", "last", "--journal", str(book[0]), "--data", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["count"]["data"]["value"] == 7


def test_half_an_export_is_a_usage_error(book: tuple[Path, str], capsys: Any) -> None:
    with pytest.raises(SystemExit) as left:
        main(["runs", "last", "--journal", str(book[0]), "--to", "csv"])
    assert left.value.code == 2
    assert "--to and -o go together" in capsys.readouterr().err
