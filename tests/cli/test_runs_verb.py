"""`grip runs` lists what was run in a project, the newest last."""

import json

import pytest

from grip_bt.cli.__main__ import main


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
