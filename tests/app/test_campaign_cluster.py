"""Campaigns on a cluster: the same rows as on one machine, whatever dies meanwhile; runs and files travel whole."""

import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from grip_bt.app.campaign import cluster
from grip_bt.app.campaign.file import read_campaign
from grip_bt.app.campaign.results import digest_of, read
from grip_bt.cli.__main__ import main
from grip_bt.runtime import Journal, JournalReader
from grip_bt.runtime.journal_rows import take_over

TASK = """grip: 1
name: fall
inputs: {seed: {type: int, value: 0}, died: {type: str, value: ''}}
data: {seen: {type: int, value: 0}}
root:
  kind: sequence
  children:
    fall: {node: own/fall, in: {kind: died}, out: {seen: seen}}
"""
NODE = '''
import os
import signal
from pathlib import Path

import grip_bt


def parent_of(pid):
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


@grip_bt.leaf("own/fall", outputs={"seen": int})
def fall(kind: str) -> int:
    """Kill once the worker that this runs under, or its node with it."""
    if kind and not Path(kind).exists():
        victims = [os.getppid()] if kind.endswith("worker") else [parent_of(os.getppid()), os.getppid()]
        Path(kind).write_text(" ".join(map(str, [*victims, os.getpid()])))
        for victim in victims:
            os.kill(victim, signal.SIGKILL)
        signal.pause()
    return len(kind)
'''
CAMPAIGN = """campaign: 1
task: tasks/fall.yaml
robot: fake
seeds: {{count: 2}}
repeat: 0
measure: {{seen: seen}}
variants:
  calm: {{}}
  worker: {{set: {{died: {folder}/worker}}}}
  node: {{set: {{died: {folder}/node}}}}
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    texts = {"grip.yaml": "grip: 1\n", "tasks/fall.yaml": TASK, "nodes/own.py": NODE}
    for name, text in {**texts, "campaigns/c.yaml": CAMPAIGN.format(folder=tmp_path)}.items():
        (tmp_path / "lab" / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / "lab" / name).write_text(text)
    return tmp_path / "lab"


@pytest.fixture
def two_nodes(tmp_path: Path, monkeypatch):
    """Two nodes with a processor each, and a head without; their address. All on the loopback."""
    reason = "its wheel is 73 MB for this test; `make packaging` tries the extra `cluster`"
    utils = pytest.importorskip("ray.cluster_utils", reason=reason)
    for name, value in (("RAY_USAGE_STATS_ENABLED", "0"), ("RAY_raylet_start_wait_time_s", "300")):
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    small = {"object_store_memory": 80 * 2**20, "include_dashboard": False}
    nodes = utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "node_ip_address": "127.0.0.2", **small})
    try:
        for number in (3, 4):
            nodes.add_node(num_cpus=1, node_ip_address=f"127.0.0.{number}", **small)
        yield nodes.address
    finally:
        nodes.shutdown()


@pytest.mark.slow
def test_two_nodes_give_what_one_machine_gives_though_a_worker_and_a_node_are_killed(project, two_nodes, tmp_path):
    def bench(name: str, *more: str) -> list[dict]:
        command = [
            sys.executable,
            "-m",
            "grip_bt.cli",
            "bench",
            "campaigns/c.yaml",
            "-o",
            tmp_path / f"{name}.jsonl",
            *more,
        ]
        done = subprocess.run(command, cwd=project, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return read(tmp_path / f"{name}.jsonl").rows

    def compared(rows: list[dict]) -> dict[str, dict]:
        return {row["trial"]: {k: v for k, v in row.items() if k not in ("wall", "duration", "run")} for row in rows}

    there = bench("there", "--cluster", two_nodes)
    for kind in ("worker", "node"):
        for pid in map(int, (tmp_path / kind).read_text().split()):
            status = Path(f"/proc/{pid}/stat")
            assert not status.exists() or status.read_text().rpartition(")")[2].split()[0] == "Z"
    assert compared(there) == compared(bench("here"))
    assert Counter(row["trial"] for row in there) == dict.fromkeys({row["trial"] for row in there}, 1)
    assert len(there) == 6
    assert all(row["success"] for row in there)
    with JournalReader(tmp_path / "there.sqlite") as reader:
        assert {record.id for record in reader.runs()} == {row["run"] for row in there}
        assert all(reader.events(row["run"])[-1].event == "run_ended" for row in there)


def test_without_ray_it_is_said_what_to_install(project, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    assert main(["bench", str(project / "campaigns/c.yaml"), "--cluster"]) == 1
    assert "pip install 'grip-bt[cluster]'" in capsys.readouterr().err


def test_a_projects_files_travel_whole_without_what_is_hidden(project, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (project / ".grip").mkdir()
    (project / ".grip/runs.sqlite").write_text("many runs")
    (project / "mesh.stl").symlink_to(tmp_path / "elsewhere.stl")
    (tmp_path / "elsewhere.stl").write_text("solid")
    (project / "nodes").rename(tmp_path / "shared")
    (project / "grip.yaml").write_text("grip: 1\nnodes: ../shared\n")
    campaign = read_campaign(project / "campaigns/c.yaml")
    content, name = cluster._packed(campaign)
    folder = cluster._unpacked(content, "some digest")
    assert cluster._unpacked(b"", "some digest") == folder
    assert digest_of(folder / "lab") == digest_of(project)
    assert (folder / "lab/mesh.stl").read_text() == "solid"
    assert not (folder / "lab/.grip").exists()
    assert (folder / "shared/own.py").read_text() == NODE
    assert read_campaign(folder / name).trials() == campaign.trials()


def test_runs_of_another_journal_are_taken_over_whole(tmp_path):
    for name in ("one", "two"):
        with Journal(tmp_path / name) as journal:
            for number in range(2):
                log = journal.begin(f"{name} {number}", seed=number)
                log.append(0.1, "root/a", "write", data={"variable": "x", "type": "list"})
                log.append(0.2, "/", "run_ended", data={"status": "success"})
                log.end("success", "success")
    before = {}
    for name in ("one", "two"):
        with JournalReader(tmp_path / name) as reader:
            before |= {record.id: (record, reader.events(record.id)) for record in reader.runs()}
    take_over(tmp_path / "one", tmp_path / "two")
    with JournalReader(tmp_path / "one") as reader:
        assert {record.id: (record, reader.events(record.id)) for record in reader.runs()} == before
