"""`grip new` makes a project whose first task is right and runs."""

import pytest

from grip_bt.cli.__main__ import main


def test_a_new_projects_first_task_is_valid_canonical_and_runs(tmp_path, capsys):
    folder = tmp_path / "lab"
    assert main(["new", str(folder)]) == 0
    assert f"grip run {folder}/tasks/first.yaml" in capsys.readouterr().out
    task = str(folder / "tasks" / "first.yaml")
    assert main(["check", task]) == 0
    assert main(["fmt", "--check", task]) == 0
    assert main(["run", task, "--robot", "fake"]) == 0
    assert (folder / ".gitignore").read_text().splitlines()[0] == ".grip/"


@pytest.mark.parametrize("existing", ["file", "folder"])
def test_nothing_is_written_where_something_is(tmp_path, capsys, existing):
    target = tmp_path / "lab"
    if existing == "file":
        target.write_text("mine")
    else:
        target.mkdir()
        (target / "notes.txt").write_text("mine")
    assert main(["new", str(target)]) == 1
    assert "is not an empty folder; nothing was written" in capsys.readouterr().err
    assert not (tmp_path / "lab" / "grip.yaml").exists()


def test_a_fresh_clone_counts_as_empty(tmp_path):
    (tmp_path / ".git").mkdir()
    assert main(["new", str(tmp_path)]) == 0
