"""Runs as episodes of a LeRobotDataset (v3): what each camera saw, where joints were and were sent, task, success.

A journal has no film: a run in simulation is run once more, since its seed repeats it, and is filmed meanwhile. Each
episode has files of its own, so that a folder grows without what is there being written again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from grip_bt.base.errors import GripError
from grip_bt.runtime import Event, JournalReader, RunRecord
from grip_sim.cameras.rig import RATE

from .resume_plan import recorded_file

_CHUNK = 1000
"""Files in a folder."""
_SAMPLES = 50
"""Frames of an episode by which the statistics of its pictures are estimated."""
_TASK = "__index_level_0__"
"""Where pandas looks for the index of the table of tasks."""
_SCALARS = dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64") | {"timestamp": "float32"}


@contextmanager
def write_lerobot(reader: JournalReader, record: RunRecord, folder: Path) -> Iterator[Callable[[Event], object]]:
    """Add a run to the dataset in a folder, which is made where there is none.

    Raises:
        MissingPartError: `pyarrow` isn't installed.
        GripError: the run can't be repeated, or the dataset is of other joints or cameras.
    """
    import pyarrow.parquet  # noqa: F401 - of the extra `parquet`; missing, it is told before anything runs

    with TemporaryDirectory() as made:
        text, success = _again(reader, record, Path(made))
        _add(folder, Path(made), text, success)
    yield lambda event: None


def _again(reader: JournalReader, record: RunRecord, folder: Path) -> tuple[str, bool]:
    """Run it again, filmed into a folder; return its task in words, and whether the referee agrees that it was done."""
    from .execute import OPTIONS, open_session  # which imports what makes exports
    from .verdict import Verdict

    before = _done(reader, record.id)
    began = next((e for e in reader.iterate(record.id) if e.event == "run_started"), None)
    said = {} if began is None else began.data.get("options", {})
    if said.get("robot") != "sim" or record.status not in ("success", "failure"):
        raise GripError(f"run {record.id} has no film and isn't one of a simulated robot that has come to its end")
    file, options = recorded_file(record.task_path, reader.file), OPTIONS.validate_python(said)
    if file.read_text(encoding="utf-8") != record.task_text:
        raise GripError(f"{file} has changed since run {record.id}, which can't be filmed any more; run it again")
    journal = folder / "again.sqlite"
    with open_session(file, replace(options, pace=None, journal=journal)) as session:
        assert session.resources.world is not None, "the robot is simulated"
        verdict = Verdict(session)
        with session.resources.world.recorded(folder):
            result = session.runner.run()
        success = result.status == "success" and not verdict.facts(result).get("contradiction")
        text = " ".join((session.document.task.doc or record.task_name).split())
    with JournalReader(journal) as other:
        if _done(other, session.runner.run_id) != before:
            raise GripError(
                f"run {record.id} went otherwise when it was repeated; its project has changed, or a component"
            )
    return text, success


def _done(reader: JournalReader, run: str) -> list[tuple[Any, ...]]:
    kinds = ("enter", "exit", "interrupted")
    return [(e.path, e.event, e.outcome, e.code, e.t) for e in reader.iterate(run) if e.event in kinds]


def _add(folder: Path, made: Path, text: str, success: bool) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    joints = np.load(made / "joints.npz")
    names, count = joints["names"].tolist(), len(joints["positions"])
    films = {f"observation.images.{film.stem}": film for film in sorted(made.glob("*.mp4"))}
    features = {key: {"dtype": kind, "shape": [1], "names": None} for key, kind in _SCALARS.items()}
    features |= {"next.success": {"dtype": "bool", "shape": [1], "names": None}}
    features |= dict.fromkeys(
        ("observation.state", "action"), {"dtype": "float32", "shape": [len(names)], "names": names}
    )
    pictures = {key: _pictures(film) for key, film in films.items()}
    features |= {key: _video(frames.shape[1:]) for key, frames in pictures.items()}
    file = folder / "meta" / "info.json"
    info = json.loads(file.read_text(encoding="utf-8")) if file.exists() else _new(features)
    if info["features"] != features:
        raise GripError(f"{folder} is a dataset of other joints or cameras; name another folder")
    tasks_file = folder / "meta" / "tasks.parquet"
    tasks = parquet.read_table(tasks_file)[_TASK].to_pylist() if tasks_file.exists() else []
    tasks = list(dict.fromkeys([*tasks, text]))
    episode, first = info["total_episodes"], info["total_frames"]
    where = {"chunk_index": episode // _CHUNK, "file_index": episode % _CHUNK}
    rows: dict[str, Any] = {
        "observation.state": joints["positions"].astype(np.float32),
        "action": joints["targets"].astype(np.float32),
        "next.success": success & (np.arange(count) == count - 1),
        "timestamp": (np.arange(count) / RATE).astype(np.float32),
        "frame_index": np.arange(count),
        "episode_index": np.full(count, episode),
        "index": first + np.arange(count),
        "task_index": np.full(count, tasks.index(text)),
    }
    stats = {key: _statistics(values.reshape(count, -1).astype(float)) for key, values in rows.items()}
    stats |= {key: _statistics(frames.reshape(-1, 3) / 255, (3, 1, 1)) for key, frames in pictures.items()}
    entry = {"episode_index": episode, "tasks": [text], "length": count, "dataset_from_index": first}
    entry |= {"dataset_to_index": first + count} | {f"data/{key}": n for key, n in where.items()}
    entry |= {f"meta/episodes/{key}": n for key, n in where.items()}
    for key, film in films.items():
        entry |= {f"videos/{key}/{part}": n for part, n in where.items()}
        entry |= {f"videos/{key}/from_timestamp": 0.0, f"videos/{key}/to_timestamp": count / RATE}
        target = folder / info["video_path"].format(video_key=key, **where)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(film.read_bytes())
    entry |= {f"stats/{key}/{name}": value for key, each in stats.items() for name, value in each.items()}
    tables = {
        folder / info["data_path"].format(**where): {key: list(values) for key, values in rows.items()},
        folder / "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet".format(**where): {
            key: [value] for key, value in entry.items()
        },
    }
    for path, table in tables.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(pa.table(table), path)
    kinds = {"task_index": ("int64", "int64"), _TASK: ("unicode", "object")}
    columns = [
        {"name": n if n != _TASK else None, "field_name": n, "pandas_type": k[0], "numpy_type": k[1]}
        for n, k in kinds.items()
    ]
    index = {"index_columns": [_TASK], "column_indexes": [], "columns": [c | {"metadata": None} for c in columns]}
    table = pa.table({"task_index": list(range(len(tasks))), _TASK: tasks})
    parquet.write_table(table.replace_schema_metadata({"pandas": json.dumps(index)}), tasks_file)
    stats_file = folder / "meta" / "stats.json"
    old = json.loads(stats_file.read_text(encoding="utf-8")) if stats_file.exists() else {}
    stats = {key: _together(old[key], each) if key in old else each for key, each in stats.items()}
    stats_file.write_text(json.dumps(stats), encoding="utf-8")
    info |= {"total_episodes": episode + 1, "total_frames": first + count, "total_tasks": len(tasks)}
    file.write_text(json.dumps(info | {"splits": {"train": f"0:{episode + 1}"}}, indent=2), encoding="utf-8")


def _new(features: dict[str, Any]) -> dict[str, Any]:
    files = "chunk-{chunk_index:03d}/file-{file_index:03d}"
    info: dict[str, Any] = {"codebase_version": "v3.0", "robot_type": "grip", "fps": RATE, "features": features}
    info |= {"data_path": f"data/{files}.parquet", "video_path": f"videos/{{video_key}}/{files}.mp4"}
    info |= {"chunks_size": _CHUNK, "data_files_size_in_mb": 100, "video_files_size_in_mb": 200}
    return info | dict.fromkeys(("total_episodes", "total_frames", "total_tasks"), 0)


def _video(shape: tuple[int, ...]) -> dict[str, Any]:
    height, width, channels = shape
    size = {"video.height": height, "video.width": width, "video.channels": channels, "video.fps": RATE}
    said = {"video.codec": "mpeg4", "video.pix_fmt": "yuv420p", "video.is_depth_map": False, "has_audio": False}
    return {"dtype": "video", "shape": list(shape), "names": ["height", "width", "channels"], "info": size | said}


def _pictures(film: Path) -> Any:
    """Return frames of a film at even distances, shape (n, height, width, 3) uint8, red green blue."""
    import cv2

    reader = cv2.VideoCapture(str(film))
    frames = [
        frame[:, :, ::-1]
        for _ in range(int(reader.get(cv2.CAP_PROP_FRAME_COUNT)))
        if (frame := reader.read()[1]) is not None
    ]
    return np.array(frames[:: max(1, len(frames) // _SAMPLES)])


def _statistics(rows: Any, shape: tuple[int, ...] = (-1,)) -> dict[str, Any]:
    """Return what policies normalise by, of rows of shape (n, k)."""
    found = {name: getattr(rows, name)(axis=0).reshape(shape).tolist() for name in ("min", "max", "mean", "std")}
    return {**found, "count": [len(rows)]}


def _together(one: dict[str, Any], two: dict[str, Any]) -> dict[str, Any]:
    """Return the statistics of two samples as of one (Chan et al.'s rule for variances)."""
    a, b = ({name: np.array(value, float) for name, value in each.items()} for each in (one, two))
    share = b["count"] / (a["count"] + b["count"])
    mean = a["mean"] + share * (b["mean"] - a["mean"])
    spread = (1 - share) * (a["std"] ** 2 + (a["mean"] - mean) ** 2) + share * (b["std"] ** 2 + (b["mean"] - mean) ** 2)
    found = {"min": np.minimum(a["min"], b["min"]), "max": np.maximum(a["max"], b["max"]), "mean": mean}
    rest = {"std": np.sqrt(spread).tolist(), "count": (a["count"] + b["count"]).astype(int).tolist()}
    return {name: value.tolist() for name, value in found.items()} | rest
