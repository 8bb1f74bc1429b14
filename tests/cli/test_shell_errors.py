"""What the shell says to somebody who names the wrong thing: where it is, what was meant, what to do."""

import pytest

from grip_bt.base.errors import NotWritableError
from grip_bt.cli.__main__ import main
from grip_bt.ros.interfaces import build_interfaces

TASK = "grip: 1\nname: first\nroot: {node: flow/succeed}\n"
MESSAGE = "float64 x\n"
PACKAGE = '<package format="3"><name>shell_msgs</name><version>1.0.0</version></package>\n'


@pytest.fixture
def project(tmp_path, monkeypatch):
    folder = tmp_path / "Prüf stand ñ"
    (folder / "tasks").mkdir(parents=True)
    (folder / "grip.yaml").write_text("grip: 1\ncomponents: components\n")
    (folder / "tasks" / "first.yaml").write_text(TASK)
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.parametrize(
    ("words", "meant"),
    [(["chek"], "check"), (["run", "--robot", "fak"], "fake"), (["component", "tets"], "test")],
)
def test_a_misspelt_word_is_answered_with_the_nearest_one(words, meant, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert f"did you mean {meant!r}?" in capsys.readouterr().err


def test_a_word_like_no_other_is_answered_with_all_of_them(capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["zzzz"])
    said = capsys.readouterr().err
    assert "'check'" in said
    assert "did you mean" not in said


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ("first.yaml", "No such file or directory; did you mean tasks/first.yaml?"),
        ("tasks/frist.yaml", "No such file or directory; did you mean tasks/first.yaml?"),
        (".", "Is a directory; name a file in it, such as tasks/first.yaml"),
        ("tasks", "Is a directory; name a file in it, such as tasks/first.yaml"),
        ("elsewhere/other.yaml", "No such file or directory\n"),
    ],
)
def test_a_file_that_is_not_there_brings_the_one_that_was_meant(project, named, said, capsys):
    assert main(["run", named]) == 1
    assert said in capsys.readouterr().err


def test_a_project_path_with_spaces_and_other_letters_runs_as_any(project, capsys):
    assert main(["run", "tasks/first.yaml", "--in-process"]) == 0
    assert main(["runs", "last", "--to", "jsonl", "-o", "été 1.jsonl"]) == 0
    assert "été 1.jsonl: " in capsys.readouterr().out


def test_a_project_that_cannot_be_written_says_what_to_do_and_runs_with_another_journal(project, capsys):
    (project / ".grip").write_text("a file where the folder would be")
    assert main(["run", "tasks/first.yaml", "--in-process"]) == 1
    said = capsys.readouterr().err
    assert f"{project / '.grip'} can't be written" in said
    assert "copy the project to a folder of yours, or give --journal FILE" in said
    assert main(["run", "tasks/first.yaml", "--in-process", "--journal", str(project / "other.sqlite")]) == 0


def test_a_cache_that_cannot_be_written_is_named_with_the_way_out(tmp_path, monkeypatch):
    (tmp_path / "package" / "msg").mkdir(parents=True)
    (tmp_path / "package" / "msg" / "One.msg").write_text(MESSAGE)
    (tmp_path / "package" / "package.xml").write_text(PACKAGE)
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(NotWritableError, match="set XDG_CACHE_HOME to a folder of yours"):
        build_interfaces(tmp_path / "package")


def test_a_place_that_the_system_refuses_is_one_sentence_not_a_traceback(project, capsys):
    assert main(["new", "x" * 300]) == 1
    said = capsys.readouterr().err
    assert said.startswith("grip: xxx")
    assert "File name too long; name another place, or change its permissions" in said


def test_nothing_to_launch_is_told_apart_from_no_project(project, tmp_path, capsys):
    assert main(["launch"]) == 1
    assert f"{project / 'grip.yaml'} declares no processes; " in capsys.readouterr().err
    assert main(["launch", "--project", str(tmp_path)]) == 1
    assert f"{tmp_path / 'grip.yaml'} doesn't exist; pass --project, " in capsys.readouterr().err


def test_a_project_without_components_says_how_to_make_one(project, capsys):
    assert main(["component", "list"]) == 0
    assert "`grip component new NAME` makes one" in capsys.readouterr().err


def test_a_check_of_a_file_that_is_not_there_asks_one_question(project, capsys):
    assert main(["check", "first.yaml"]) == 1
    assert "did you mean tasks/first.yaml?\n" in capsys.readouterr().out


def test_the_next_step_of_a_new_component_can_be_pasted(project, capsys):
    assert main(["component", "new", "my_grasps"]) == 0
    assert f"next: grip component test '{project / 'components' / 'my_grasps'}'; " in capsys.readouterr().out


@pytest.mark.parametrize(
    "words", [["runs"], ["component", "list"], ["replay", "last"], ["launch"], ["launch", "--check"]]
)
def test_what_only_looks_leaves_nothing_in_a_folder(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main(words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("pace", ["0", "-1", "nan", "inf", "fast"])
def test_a_pace_that_is_none_is_a_usage_error(project, capsys, pace):
    with pytest.raises(SystemExit) as ended:
        main(["run", "task.yaml", f"--pace={pace}"])
    assert ended.value.code == 2
    assert f"'{pace}' isn't a number above 0; leave it out" in capsys.readouterr().err
