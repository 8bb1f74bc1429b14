"""Runs in simulation as episodes of a LeRobotDataset (v3): what each camera saw, joints, actions, task, success.

A journal has no film: the run is run again for each camera of its world, since its seed repeats it, and is filmed. An
action is where the joints are a frame later. Each episode has files of its own, so that a folder grows without what is
there being written again. Format: https://github.com/huggingface/lerobot.
"""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
import pyarrow as pa
from pyarrow import parquet

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError
from grip_bt.base.ports import Arm, Hand
from grip_bt.runtime import JournalReader
from grip_sim.cameras.rig import RATE

from .execute import OPTIONS, RunOptions, Session, open_session
from .verdict import Verdict

_CHUNK = 1000
"""Files in a folder."""
_SAMPLES = 50
"""Frames of an episode by which the statistics of its pictures are estimated."""
_TASK = "__index_level_0__"
"""Where pandas looks for the index of the table of tasks."""
_SCALARS = dict.fromkeys(("frame_index", "episode_index", "index", "task_index"), "int64") | {"timestamp": "float32"}


def add_run(reader: JournalReader, run: str, folder: Path) -> int:
    """Add a run of a journal to a dataset, and return how many frames it has.

    Raises:
        GripError: it wasn't simulated, has no end, or can't be repeated; the dataset is of other joints or cameras.
    """
    record = reader.run(run)
    began = next((event for event in reader.iterate(run) if event.event == "run_started"), None)
    said = {} if began is None else began.data.get("options", {})
    if said.get("robot") != "sim" or record.status not in ("success", "failure"):
        raise GripError(f"run {run} isn't one of a simulated robot that has come to its end")
    file, options = Path(record.task_path), OPTIONS.validate_python(said)
    if file.read_text(encoding="utf-8") != record.task_text:
        raise GripError(f"{file} has changed since run {run}, which can't be filmed any more; run it again")
    with TemporaryDirectory() as place:
        made = Path(place)
        options = replace(options, journal=made / "again.sqlite")
        names, joints, text, success, cameras = again(file, options, "", made, done(reader, run))
        for camera in cameras[1:]:
            again(file, options, camera, made, done(reader, run))
        films = {camera: made / f"{camera}.mp4" for camera in cameras}
        count = min(len(joints), *(len(frames_of(film)) for film in films.values()))
        add(folder, films, names, joints[:count], text, success)
    return count


def again(
    file: Path, options: RunOptions, camera: str, folder: Path, before: list[tuple[Any, ...]]
) -> tuple[list[str], Array, str, bool, list[str]]:
    """Run a task again, filmed by a camera, or by the first one; GripError where it doesn't go as it went before.

    Returns:
        names of joints, their positions in each frame, the task in words, whether it was done, and the world's cameras.
    """
    with open_session(file, options) as session:
        world = session.resources.world
        assert world is not None, "the robot is simulated"
        cameras, verdict = [each.name for each in world.spec.cameras], Verdict(session)
        camera = camera or cameras[0]
        watch = Watch(session)
        with world.filmed(camera, folder / f"{camera}.mp4"):
            watch.start()
            result = session.runner.run()
            watch.end()
        success = result.status == "success" and not verdict.facts(result).get("contradiction")
        text = " ".join((session.document.task.doc or session.document.task.name).split())
        run = session.runner.run_id
    assert options.journal is not None, "it is recorded"
    assert run is not None, "likewise"
    with JournalReader(options.journal) as other:
        if done(other, run) != before:
            raise GripError("the run went otherwise when it was repeated: its project has changed, or a component")
    return watch.names, watch.frames(), text, success, cameras


class Watch(threading.Thread):
    """Asks where the joints are, as often as the simulator looks up: 60 times a simulated second."""

    def __init__(self, session: Session):
        super().__init__(daemon=True)
        self._now = session.runner.context.clock.now
        self._parts: list[Arm | Hand] = [*session.resources.arms.values(), *session.resources.hands.values()]
        self._over = threading.Event()
        self.names = [name for part in self._parts for name in part.state().names]
        self._rows: list[tuple[float, Array]] = []

    def _look(self) -> None:
        states = [part.state() for part in self._parts]
        self._rows.append((self._now(), np.concatenate([state.position for state in states])))

    def run(self) -> None:
        """Look until the end."""
        while not self._over.is_set():
            self._look()

    def end(self) -> None:
        """Look once more, and no more then."""
        self._over.set()
        self.join()
        self._look()

    def frames(self) -> Array:
        """Return the positions at the time of each frame, shape (frames, joints) [rad or m]."""
        times, rows = np.array([time for time, _ in self._rows]), np.array([row for _, row in self._rows])
        due = times[0] + np.arange(int((times[-1] - times[0]) * RATE + 1e-6) + 1) / RATE
        return np.column_stack([np.interp(due, times, column) for column in rows.T])


def done(reader: JournalReader, run: str) -> list[tuple[Any, ...]]:
    """Return which nodes of a run began and ended, how, and when."""
    kinds = ("enter", "exit", "interrupted")
    return [(e.path, e.event, e.outcome, e.code, e.t) for e in reader.iterate(run) if e.event in kinds]


def add(folder: Path, films: dict[str, Path], names: list[str], joints: Array, text: str, success: bool) -> None:
    """Add an episode to the dataset in a folder, which is made where there is none.

    Args:
        films: camera -> an MPEG-4 file.
        joints: positions of the joints `names` in each frame, shape (frames, joints) [rad or m].
        text: the task, in words.
    """
    count, films = len(joints), {f"observation.images.{camera}": film for camera, film in films.items()}
    features: dict[str, dict[str, Any]] = {
        key: {"dtype": kind, "shape": [1], "names": None} for key, kind in _SCALARS.items()
    }
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
        "observation.state": joints.astype(np.float32),
        "action": np.vstack([joints[1:], joints[-1:]]).astype(np.float32),
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


def frames_of(film: Path) -> Any:
    """Return the frames of a film, shape (n, height, width, 3) uint8, red green blue."""
    reader, frames = cv2.VideoCapture(str(film)), []
    while (frame := reader.read()[1]) is not None:
        frames.append(frame[:, :, ::-1])
    return np.array(frames)


def _pictures(film: Path) -> Any:
    frames = frames_of(film)
    return frames[:: max(1, len(frames) // _SAMPLES)]


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
