"""Tasks read, keep, take and forget named values."""

from __future__ import annotations

import textwrap

import pytest

import grip_bt as grip
from grip_bt.base.message_store import MessageLibrary, load
from grip_bt.base.value_codec import decode

POSES = "bin: {reference_frame: world, position: {x: 0.1, y: 0.2, z: 0.3}, orientation: {r: 0, p: 0, y: 0}}\n"


@pytest.fixture
def project(tmp_path):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "messages").mkdir()
    (tmp_path / "messages" / "poses.yaml").write_text(POSES)
    return tmp_path


def run(project, data: str, children: str, **options):
    task = project / "task.yaml"
    body = textwrap.indent(textwrap.dedent(children).strip(), "    ")
    task.write_text(f"grip: 1\nname: it\ndata: {data}\nroot:\n  kind: sequence\n  children:\n{body}\n")
    return grip.run(task, robot="fake", **options)


def kept(project):
    """Return the stores that a run has saved."""
    library = MessageLibrary()
    load(lambda name: library.store(name, make=True), project / ".grip" / "messages.values.sqlite", decode)
    return library


def test_a_value_is_read_kept_under_another_name_and_read_again(project):
    result = run(
        project,
        "{a: Pose, b: Pose, names: 'list[str]', wanted: {type: str, value: copy}}",
        """
        get: {node: messages/get, with: {store: poses, name: bin, type: Pose}, out: {value: a}}
        put: {node: messages/put, with: {store: poses, name: copy}, in: {value: a}}
        select: {node: messages/select, with: {store: poses, type: Pose}, in: {name: wanted}, out: {value: b}}
        delete: {node: messages/delete, with: {store: poses, name: bin}}
        list: {node: messages/list, with: {store: poses}, out: {names: names}}
        see: {node: messages/put, with: {store: seen, name: pose}, in: {value: b}}
        see_names: {node: messages/put, with: {store: seen, name: names}, in: {value: names}}
        save: {node: messages/save}
        """,
    )
    assert result.status == "success"
    seen = kept(project).store("seen")
    assert list(seen.get("pose").position) == [0.1, 0.2, 0.3]
    assert (seen.get("names"), seen.entry("pose").provenance) == (["copy"], "see")


def test_what_is_not_there_or_of_another_type_is_a_failure_with_a_code(project):
    missing = run(project, "{a: Pose}", "x: {node: messages/get, with: {store: poses, name: bim}, out: {value: a}}")
    assert (missing.status, missing.failure.code) == ("failure", "no_entry")
    assert "did you mean 'bin'" in missing.failure.message
    other = run(
        project,
        "{a: Any}",
        "x: {node: messages/get, with: {store: poses, name: bin, type: Grasp}, out: {value: a}}",
    )
    assert (other.status, other.failure.code) == ("failure", "bad_reply")
    empty = run(project, "{a: Any}", "x: {node: messages/take, with: {store: poses}, out: {value: a}}")
    assert (empty.status, empty.failure.code) == ("failure", "empty")


def test_a_queue_passes_values_in_order(project):
    result = run(
        project,
        "{a: {type: int, value: 1}, b: {type: int, value: 2}, x: Any, y: Any}",
        """
        one: {node: messages/push, with: {store: numbers}, in: {value: a}}
        two: {node: messages/push, with: {store: numbers}, in: {value: b}}
        first: {node: messages/take, with: {store: numbers}, out: {value: x}}
        second: {node: messages/take, with: {store: numbers}, out: {value: y}}
        see: {node: messages/put, with: {store: seen, name: x}, in: {value: x}}
        see_too: {node: messages/put, with: {store: seen, name: y}, in: {value: y}}
        save: {node: messages/save}
        """,
    )
    seen = kept(project).store("seen")
    assert (result.status, seen.get("x"), seen.get("y")) == ("success", 1, 2)


def test_what_is_saved_is_there_in_the_next_run_and_what_is_not_is_forgotten(project):
    keep = """
        get: {node: messages/get, with: {store: poses, name: bin}, out: {value: a}}
        put: {node: messages/put, with: {store: poses, name: kept}, in: {value: a}}
        """
    save = "        save: {node: messages/save}\n"
    read = """
        x: {node: messages/get, with: {store: poses, name: kept, type: Pose}, out: {value: a}}
        see: {node: messages/put, with: {store: seen, name: x}, in: {value: a}}
        """
    run(project, "{a: Any}", keep)
    assert run(project, "{a: Any}", read).failure.code == "no_entry"
    run(project, "{a: Any}", keep.rstrip() + "\n" + save)
    assert run(project, "{a: Any}", read.rstrip() + "\n" + save).status == "success"
    assert list(kept(project).store("seen").get("x").position) == [0.1, 0.2, 0.3]
    again = run(project, "{a: Any}", "        r: {node: messages/reinitialise}\n" + read.strip("\n"))
    assert again.failure.code == "no_entry"


def test_a_name_that_is_nowhere_is_told_before_the_run(tmp_path):
    """The first GRIP told it in the middle of a run, and planned to an empty goal; here with the check of the task."""
    from grip_bt.app.runs.execute import check_task

    (tmp_path / "messages").mkdir()
    (tmp_path / "messages/joint_states.yaml").write_text("above_bin: {panda_joint1: 1.49}\n")
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    text = "grip: 1\nname: get\nroot: {node: messages/get, with: {store: joint_states, name: abov_bin}}\n"
    (tmp_path / "task.yaml").write_text(text)
    report = check_task(tmp_path / "task.yaml")[2]
    (issue,) = report.issues
    assert issue.code == "unknown-message"
    assert "store 'joint_states' has no message 'abov_bin'; did you mean 'above_bin'?" in issue.message
    (tmp_path / "task.yaml").write_text(text.replace("abov_", "above_"))
    assert check_task(tmp_path / "task.yaml")[2].issues == ()
    (tmp_path / "task.yaml").write_text(text)
    (tmp_path / "grip.yaml").write_text("grip: 1\nmessage_server: true\n")
    assert check_task(tmp_path / "task.yaml")[2].issues == ()  # what a server holds is known when it is asked
