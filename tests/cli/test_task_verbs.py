import io
import json
from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "tasks" / "reactive_pick.yaml")
WRONG = "grip: 1\nname: a\nroot: {node: flow/wiat}\n"
UGLY = "name: a  # why\ngrip: 1\nroot:\n    node: flow/succeed\n"
TIDY = "grip: 1\nname: a  # why\nroot: {node: flow/succeed}\n"


@pytest.fixture
def file(tmp_path):
    def make(text):
        path = tmp_path / "t.yaml"
        path.write_text(text)
        return path

    return make


def test_the_example_is_clean_and_canonical(capsys):
    assert main(["check", EXAMPLE]) == 0
    assert capsys.readouterr().out == f"{EXAMPLE}: ok\n"
    assert main(["fmt", "--check", EXAMPLE]) == 0


def test_check_reports_all_issues_of_all_tasks_and_fails(file, capsys):
    path = file(WRONG)
    assert main(["check", str(path), EXAMPLE, "nothing.yaml"]) == 1
    out = capsys.readouterr().out
    assert f"{path}:3:8: error[unknown-node]" in out
    assert "did you mean 'flow/wait'" in out
    assert "nothing.yaml:1:1: error[bad-document]" in out
    assert f"{EXAMPLE}: ok" in out


def test_a_projects_folder_stands_for_all_its_tasks(tmp_path, capsys):
    (tmp_path / "tasks/more").mkdir(parents=True)
    for name, text in {"a.yaml": WRONG, "more/b.yaml": TIDY, "more/b.layout.yaml": "grip: 1\n"}.items():
        (tmp_path / "tasks" / name).write_text(text)
    assert main(["check", str(tmp_path)]) == 1
    ends = [line for line in capsys.readouterr().out.splitlines() if line.endswith(("errors", "error", "warning"))]
    assert [line.rpartition(": ")[0] for line in ends] == [
        str(tmp_path / f"tasks/{name}.yaml") for name in ("a", "more/b")
    ]
    assert main(["check", str(tmp_path / "tasks/more")]) == 1  # no project's folder


def test_check_prints_json_and_the_schema(file, capsys):
    assert main(["check", "--json", str(file(WRONG))]) == 1
    (found,) = json.loads(capsys.readouterr().out)
    assert {"unknown-node"} <= {issue["code"] for issue in found["issues"]}
    assert main(["check", "--schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"].startswith("GRIP task")
    with pytest.raises(SystemExit, match="2"):
        main(["check"])


def test_fmt_writes_the_canonical_form_and_check_only_looks(file, capsys):
    path = file(UGLY)
    path.chmod(0o640)
    assert main(["fmt", "--check", str(path)]) == 1
    assert path.read_text() == UGLY
    assert main(["fmt", str(path)]) == 0
    assert path.read_text() == TIDY
    assert path.stat().st_mode & 0o777 == 0o640
    assert list(path.parent.iterdir()) == [path]
    assert main(["fmt", "--check", str(path)]) == 0


def test_fmt_reads_stdin(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", io.StringIO(UGLY))
    assert main(["fmt", "-"]) == 0
    assert capsys.readouterr().out == TIDY


def test_fmt_changes_nothing_when_one_file_cannot_be_read(file, tmp_path, capsys):
    path = file(UGLY)
    assert main(["fmt", str(path), str(tmp_path / "none.yaml")]) == 1
    assert path.read_text() == UGLY
    assert "No such file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("form", "begin"), [("svg", "<svg "), ("dot", "digraph "), ("mermaid", "flowchart "), ("yaml", "grip: 1\n")]
)
def test_convert_writes_each_form(form, begin, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["convert", EXAMPLE, "--to", form, "--view", "flow", "-o", str(out)]) == 0
    assert out.read_text().startswith(begin)
    assert main(["convert", EXAMPLE, "--to", form]) == 0
    assert capsys.readouterr().out.startswith(begin)
    assert main(["convert", EXAMPLE, "--to", form, "-o", str(tmp_path / "no" / "out")]) == 1
    assert "make its folder first" in capsys.readouterr().err
