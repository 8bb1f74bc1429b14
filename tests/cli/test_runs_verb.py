"""`grip runs` lists what was run in a project, the newest last."""

import json
import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest

from grip_bt.cli.__main__ import main
from grip_bt.runtime import Journal


def _task(folder, name, node):
    file = folder / f"{name}.yaml"
    file.write_text(f"grip: 1\nname: {name}\nroot: {node}\n")
    return str(file)


def test_runs_are_listed_with_their_ends_newest_last(tmp_path, capsys):
    assert main(["run", _task(tmp_path, "good", "{node: flow/succeed}")]) == 0
    assert main(["run", _task(tmp_path, "bad", "{node: flow/fail, with: {code: tired}}")]) == 3
    capsys.readouterr()
    assert main(["runs", str(tmp_path)]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.endswith("good")
    assert "success" in first
    assert second.endswith("bad")
    assert "failure" in second
    assert main(["runs", str(tmp_path), "--json"]) == 0
    assert [r["task_name"] for r in json.loads(capsys.readouterr().out)] == ["good", "bad"]


def test_a_project_without_runs_says_so(tmp_path, capsys):
    assert main(["runs", str(tmp_path)]) == 0
    assert "no runs yet" in capsys.readouterr().out


def test_old_runs_are_removed_when_it_is_asked_for(tmp_path, capsys):
    for name in ("first", "second", "third"):
        assert main(["run", _task(tmp_path, name, "{node: flow/succeed}"), "--in-process"]) == 0
    capsys.readouterr()
    assert main(["runs", str(tmp_path), "--prune"]) == 0
    assert capsys.readouterr().out.startswith("0 runs removed; ")
    assert main(["runs", str(tmp_path), "--prune", "1kB", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert len(said["removed"]) == 2
    assert said["after"] <= said["before"]
    assert main(["runs", str(tmp_path)]) == 0
    assert capsys.readouterr().out.strip().endswith("third")
    with pytest.raises(SystemExit) as end:
        main(["runs", str(tmp_path), "--prune", "much"])
    assert end.value.code == 2
    assert "--prune 'much' isn't a size; such as 500MB or 2GiB" in capsys.readouterr().err


def test_a_journal_keeps_to_the_projects_limit_after_each_run(tmp_path, capsys):
    (tmp_path / "grip.yaml").write_text("grip: 1\njournal_limit: 150 kB\n")
    words = "{node: flow/set, with: {value: '" + "x" * 400 + "'}, out: {value: v}}"
    task = tmp_path / "many.yaml"
    children = "\n".join(f"    c{i}: {words}" for i in range(100))
    task.write_text(f"grip: 1\nname: many\ndata: {{v: str}}\nroot:\n  kind: sequence\n  children:\n{children}\n")
    for _ in range(6):
        assert main(["run", str(task), "--in-process"]) == 0
    capsys.readouterr()
    assert main(["runs", str(tmp_path), "--json"]) == 0
    left = json.loads(capsys.readouterr().out)
    assert 1 <= len(left) < 6
    assert left[-1]["status"] == "success", "the newest is there"
    (tmp_path / "grip.yaml").write_text("grip: 1\njournal_limit: a lot\n")
    assert main(["run", str(task), "--in-process"]) == 1
    assert "journal_limit" in capsys.readouterr().err


def test_a_run_whose_process_is_gone_has_died_and_others_run(tmp_path, capsys):
    file = tmp_path / ".grip" / "runs.sqlite"
    begin = "import sys; from grip_bt.runtime import Journal\nwith Journal(sys.argv[1]) as j: j.begin(sys.argv[2])"
    for name in ("killed", "elsewhere", "earlier"):
        subprocess.run([sys.executable, "-c", begin, str(file), name], check=True)
    with closing(sqlite3.connect(file)) as database, database:
        of = "run = (SELECT id FROM runs WHERE task_name = ?)"
        database.execute(f"UPDATE processes SET host = 'another' WHERE {of}", ("elsewhere",))
        database.execute(f"DELETE FROM processes WHERE {of}", ("earlier",))
    with Journal(file) as journal:
        journal.begin("here")
    assert main(["runs", str(tmp_path), "--json"]) == 0
    found = {run["task_name"]: run["status"] for run in json.loads(capsys.readouterr().out)}
    assert found == {"here": "running", "killed": "died", "elsewhere": "lost", "earlier": "lost"}
    assert main(["runs", str(tmp_path)]) == 0
    assert [line.split()[5] for line in capsys.readouterr().out.splitlines() if line.endswith("killed")] == ["died"]


def test_a_run_that_could_not_begin_does_not_stay_under_way(tmp_path, capsys):
    task = _task(tmp_path, "good", "{node: flow/succeed}")
    assert main(["run", task, "--in-process", "--mock", "nope=success"]) == 1
    assert "unknown node 'nope'" in capsys.readouterr().err
    assert main(["runs", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == []


@pytest.mark.parametrize("to", ["jsonl", "csv", "mcap"])
def test_a_recording_that_cant_be_written_is_told(to, tmp_path, capsys):
    assert main(["run", _task(tmp_path, "good", "{node: flow/succeed}"), "--in-process"]) == 0
    assert main(["runs", str(tmp_path), "--to", to, "-o", str(tmp_path / "no" / "run")]) == 1
    assert f"{tmp_path / 'no' / 'run'}: can't be written: No such file or directory" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--rate", "fast", "'fast' isn't a number above 0"),
        ("--rate", "inf", "'inf' isn't a number above 0"),
        ("--watchdog", "x", "'x' isn't a number of seconds, 0 or more"),
        ("--watchdog", "-1", "'-1' isn't a number of seconds, 0 or more"),
    ],
)
def test_options_that_arent_numbers_say_which_are_allowed(option, value, said, tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        main(["run", "good.yaml", f"{option}={value}"])
    assert end.value.code == 2
    assert said in capsys.readouterr().err
