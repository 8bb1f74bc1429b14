"""The journal keeps what nodes write: as it was at that moment, once, up to a size, and gives it back to the bit."""

from __future__ import annotations

import json
import math
import random
import sqlite3
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from timed import ManualClock

from grip_bt.base.value_codec import DEEPEST, OpaqueValueError, decode, encode, snapshot
from grip_bt.base.values import Failure, Grasp, Image, JointState, PointCloud, Pose
from grip_bt.runtime import Journal, JournalError, JournalReader
from grip_bt.runtime.observers import Recorder


def random_value(rng: random.Random, depth: int = 3) -> Any:
    arrays = np.random.default_rng(rng.randrange(2**32))
    atoms = [
        lambda: rng.choice([None, True, False, math.inf, -0.0, 1e-320, 2**80, -7, "", "é\n", "$x", b"\0\xff"]),
        lambda: rng.random() * 10.0 ** rng.randint(-300, 300),
        lambda: Pose(arrays.normal(size=3), arrays.normal(size=4), rng.choice(["world", "palm"])),
        lambda: PointCloud(arrays.normal(size=(rng.choice([0, 3, 500]), 3))),
        lambda: Image(arrays.integers(0, 255, (4, 5, 3), np.uint8), "camera", 1.5),
        lambda: JointState(("a", "b"), arrays.normal(size=2)),
        lambda: Grasp(Pose(), Pose(), Pose(), posture=JointState(("f",), [0.1]), quality=rng.random()),
        lambda: Failure("no_ik", "out of reach", {"tries": 3}),
        lambda: arrays.normal(size=(rng.randint(0, 9), 7)).astype(rng.choice(["f4", "i2", "?", "c16"])),
        lambda: {1, "a"},
        lambda: frozenset({(1, 2)}),
    ]
    if depth == 0 or rng.random() < 0.4:
        return rng.choice(atoms)()
    items = [random_value(rng, depth - 1) for _ in range(rng.randint(0, 4))]
    return rng.choice(
        [
            items,
            tuple(items),
            {f"k{i}": item for i, item in enumerate(items)},
            {(i, "x"): item for i, item in enumerate(items)},
            {"$array": items},
        ]
    )


def same(one: Any, other: Any) -> bool:
    """Equality to the bit, types included."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[k], other[k]) for k in one)
    if isinstance(one, float):
        return repr(one) == repr(other)
    if hasattr(one, "__slots__"):
        return all(same(getattr(one, name), getattr(other, name)) for name in type(one).__dataclass_fields__)
    return bool(one == other)


@pytest.mark.parametrize("seed", range(200))
def test_any_value_comes_back_to_the_bit(seed: int) -> None:
    value = random_value(random.Random(seed))
    assert same(decode(encode(value)), value)
    assert same(decode(encode(snapshot(value))), value)


class Gripper:
    def __repr__(self) -> str:
        return "<a gripper, open>"


class Rude:
    def __repr__(self) -> str:
        raise RuntimeError("no")


def test_a_value_that_cannot_be_restored_says_what_it_was() -> None:
    with pytest.raises(OpaqueValueError, match=r"Gripper can't be restored from the journal: <a gripper, open>"):
        decode(encode(snapshot([Gripper()])))
    with pytest.raises(OpaqueValueError, match="repr raised RuntimeError"):
        decode(encode(snapshot(Rude())))
    endless: list[Any] = []
    endless.append(endless)
    with pytest.raises(OpaqueValueError):
        decode(encode(snapshot(endless)))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "runs.sqlite"


def write(file: Path, *values: Any, **options: Any) -> str:
    with Journal(file, **options) as journal:
        log = journal.begin("values")
        recorder = Recorder(log, ManualClock())
        for n, value in enumerate(values):
            recorder.entered("a")
            recorder.wrote("a", f"v{n % 2}", "Any", value)
            recorder.ended("a", "success", None)
    return log.id


def test_what_a_node_changes_after_it_wrote_it_is_not_changed_in_the_journal(file: Path) -> None:
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("values"), ManualClock())
        mutable = {"list": [1], "array": np.zeros(3)}
        recorder.wrote("a", "x", "Any", mutable)
        mutable["list"].append(2)  # type: ignore[union-attr]
        mutable["array"][0] = 1  # type: ignore[index]
    with JournalReader(file) as reader:
        value = reader.value(reader.variables(log.id)["x"])
    assert value["list"] == [1]
    assert not value["array"].any()


def test_equal_big_values_are_kept_once_and_found_by_their_hash(file: Path) -> None:
    cloud = PointCloud(np.random.default_rng(0).normal(size=(5000, 3)))
    run = write(file, cloud, PointCloud(cloud.points), cloud)
    with JournalReader(file) as reader:
        writes = [event for event in reader.events(run) if event.event == "write"]
        assert len({event.data["hash"] for event in writes}) == 1
        assert all(same(reader.value(event), cloud) for event in writes)
        assert writes[0].data["preview"] == "PointCloud(5000 points, frame='world')"
    with sqlite3.connect(file) as database:
        assert database.execute("SELECT count(*) FROM big_values").fetchone() == (1,)
    database.close()


def test_a_value_beyond_the_cap_leaves_its_preview_and_says_why(file: Path) -> None:
    run = write(file, PointCloud(np.zeros((1000, 3))), "small", largest_value=1000)
    with JournalReader(file) as reader:
        big, small = (reader.variables(run)[name] for name in ("v0", "v1"))
        assert reader.value(small) == "small"
        assert big.data["preview"] == "PointCloud(1000 points, frame='world')"
        with pytest.raises(JournalError, match=r"event 2 \(write at a\) has no value: larger than 1000 bytes"):
            reader.value(big)


def test_the_last_values_are_known_and_have_a_history(file: Path) -> None:
    run = write(file, *range(10))
    with JournalReader(file) as reader:
        assert {name: reader.value(event) for name, event in reader.variables(run).items()} == {"v0": 8, "v1": 9}
        assert [reader.value(event) for event in reader.history(run, "v1", 3)] == [5, 7, 9]


def test_states_of_the_planning_scene_come_back():
    from dataclasses import fields

    from grip_bt.base.values.solids import CellMap, Cylinder, Mesh, Sphere
    from grip_bt.commanders.scene import PlanningScene
    from grip_bt.commanders.scene_state import SceneSnapshot

    scene = PlanningScene({"hand": lambda: Pose()}, {"table": ((1.0, 1.0, 0.1), Pose())})
    solids = {
        "cup": Cylinder(0.04, 0.1),
        "ball": Sphere(0.03),
        "wedge": Mesh(np.vstack([np.zeros(3), np.eye(3)]), np.array([[0, 1, 2]], np.int32)),
        "cloud": CellMap(np.array([[0, 0, 0], [1, 0, 0]], np.int32), 0.02),
    }
    for name, solid in solids.items():
        scene.put(name, solid, Pose([0.5, 0.0, 0.2]))
    scene.attach("cup", "hand")
    scene.allow("ball", "*")
    before = scene.snapshot()
    after = decode(encode(snapshot(before)))
    assert isinstance(after, SceneSnapshot)
    for field in fields(before):
        assert getattr(after, field.name) == getattr(before, field.name), field.name
    scene.restore(after)
    assert scene.attached("hand") == ("cup",)


WRAPPED = {"list": lambda item: [item], "tuple": lambda item: (item,), "dict": lambda item: {"k": item}}


@pytest.mark.parametrize("kind", WRAPPED)
def test_containers_are_kept_as_deep_whatever_they_are(kind: str) -> None:
    kept: Any = 1
    for _ in range(DEEPEST):
        kept = WRAPPED[kind](kept)
    assert same(decode(encode(snapshot(kept))), kept)
    with pytest.raises(OpaqueValueError):
        decode(encode(snapshot(WRAPPED[kind](WRAPPED[kind](kept)))))


@pytest.mark.parametrize("value", [Failure("no_ik"), Grasp(Pose(), Pose(), Pose()), JointState(("a",), [0.0])])
def test_a_field_that_there_was_not_when_a_value_was_written_has_its_default(value: Any) -> None:
    head = json.loads(encode(value))
    for field in fields(value):
        if field.default is not MISSING or field.default_factory is not MISSING:
            del head["$value"][1][field.name]
    assert same(decode(json.dumps(head).encode() + b"\n"), value)


def test_a_run_that_was_cut_off_says_why_at_its_end(file: Path) -> None:
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("values"), ManualClock())
        recorder.entered("a")
        recorder.lost("nobody is there")
        recorder.lost("still nobody")
        recorder.interrupted("a")
    with JournalReader(file) as reader:
        *_, last = reader.events(log.id)
        assert (last.path, last.event, last.data) == (
            "/",
            "run_ended",
            {"status": "died", "message": "nobody is there"},
        )
        assert reader.run(log.id).status == "died"


def test_what_happens_after_a_cut_is_in_no_journal_however_late_it_is(file: Path) -> None:
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("values"), ManualClock())
        recorder.entered("a")
        recorder.lost("nobody is there")
        while log.id in journal._logs:  # until the writer has written that and turned to other runs
            journal.flush()
        recorder.interrupted("a")
        recorder.finished(None, "died")
    with JournalReader(file) as reader:
        assert [event.event for event in reader.events(log.id)] == ["enter", "run_ended"]
