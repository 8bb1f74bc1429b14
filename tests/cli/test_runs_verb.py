"""`grip runs` lists what was run in a project, the newest last."""

import json

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
