"""Names of what isn't there, isn't allowed or is of the wrong kind bring one sentence, and do no harm."""

import json
import os
import sqlite3

import pytest

from grip_bt.cli.__main__ import main

TASK = "grip: 1\nname: first\nroot:\n  kind: sequence\n  children:\n    a: {node: flow/succeed}\n"
RENAME = '{"do": "rename", "path": "a", "name": "b"}'
CAMPAIGN = "campaign: 1\ntask: t.yaml\nrobot: fake\nseeds: %s\n"


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "t.yaml").write_text(TASK)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*more):
    return main(["run", "t.yaml", "--robot", "fake", "--in-process", *more])


def test_a_new_project_where_none_can_be_is_one_sentence(capsys):
    assert main(["new", "/proc/nothing/here"]) == 1
    said = capsys.readouterr().err
    assert said == "grip: /proc/nothing: No such file or directory; make its folder first, or name another place\n"


def test_a_link_that_leads_nowhere_is_not_taken_for_what_was_meant(project, capsys):
    (project / "link.yaml").symlink_to("gone.yaml")
    assert main(["check", "link.yaml"]) == 1
    assert "No such file or directory; it leads to gone.yaml.\n" in capsys.readouterr().out


def test_a_name_that_breaks_the_line_is_never_put_into_a_sentence(project, capsys):
    (project / "t\n2.yaml").write_text(TASK)
    assert main(["check", "t2.yaml"]) == 1
    assert "did you mean t.yaml?" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "holds"), [(["run", "t.yaml", "--mocks"], "mocks"), (["bench"], "campaign, doc, task, robot")]
)
def test_an_empty_file_is_told_what_it_holds(project, words, holds, capsys):
    (project / "empty.yaml").touch()
    assert main([*words, "empty.yaml"]) == 1
    assert f"empty.yaml:1:1: the file is empty; it holds {holds}" in capsys.readouterr().err


@pytest.mark.parametrize("seed", ["-1", "4294967296", "9" * 5000, "1.5", "x", "²"])
def test_a_seed_that_is_none_is_a_usage_error(project, seed, capsys):
    with pytest.raises(SystemExit, match="2"):
        run(f"--seed={seed}")
    assert "isn't a whole number from 0 to 4294967295" in capsys.readouterr().err


@pytest.mark.parametrize(
    "seeds", ["{count: 99999999999}", "{first: -1, count: 2}", "[1, -2]", "three", "{count: x}", "-1"]
)
def test_seeds_of_a_campaign_that_are_none_are_told(project, seeds, capsys):
    (project / "c.yaml").write_text(CAMPAIGN % seeds)
    assert main(["bench", "c.yaml"]) == 1
    said = capsys.readouterr().err
    assert "seeds: whole numbers from 0 to 4294967295, such as [1, 2, 3], or {first: 0, count: 10}" in said
    assert "a count is 1 to 100000, not " in said
    assert "Input should be" not in said


def test_results_that_are_not_there_are_told_in_words(project, capsys):
    assert main(["bench", "report", "none.jsonl"]) == 1
    assert capsys.readouterr().err == (
        "grip: none.jsonl: can't be read as results of a campaign: No such file or directory; "
        "`grip bench CAMPAIGN` writes them\n"
    )


def test_a_campaign_whose_results_have_no_place_says_how_to_give_one(project, capsys):
    (project / "c.yaml").write_text(CAMPAIGN % "[1]")
    (project / ".grip").write_text("a file where the folder would be")
    assert main(["bench", "c.yaml"]) == 1
    assert "results are kept there; give another file for them with -o" in capsys.readouterr().err


@pytest.mark.parametrize("more", [["--prune"], []])
def test_a_journal_that_was_named_and_is_not_there_is_an_error(project, more, capsys):
    assert main(["runs", ".", "--journal", "other.sqlite", *more]) == 1
    assert "other.sqlite: there is no such journal; name a file that runs were written to" in capsys.readouterr().err


def test_a_journal_that_may_not_be_read_is_one_sentence(project, monkeypatch, capsys):
    assert run() == 0

    def refused(*_, **__):
        raise sqlite3.OperationalError("unable to open database file")  # as for others than root

    monkeypatch.setattr("grip_bt.runtime.journal_rows.sqlite3.connect", refused)
    assert main(["runs"]) == 1
    assert "can't be read: unable to open database file; fix its permissions" in capsys.readouterr().err


def test_a_beginning_that_several_runs_have_is_no_unknown_run(project, capsys):
    assert run() == 0
    assert run() == 0
    capsys.readouterr()
    assert main(["runs", "20"]) == 1
    said = capsys.readouterr().err
    assert "2 runs begin with '20': 20" in said
    assert said.endswith("; give more characters\n")


def test_an_end_that_a_node_never_came_to_brings_those_that_it_did(project, capsys):
    assert run() == 0
    assert main(["replay", "last", "--until", "a:failure"]) == 1
    assert "unknown place in the run 'a:failure' (available: a:success)" in (capsys.readouterr().err)
    assert main(["replay", "last", "--until", "²"]) == 1
    assert "unknown place in the run '²' (available: /, a)" in capsys.readouterr().err


def test_a_task_whose_name_is_no_text_keeps_its_journal(project, capsys):
    name = os.fsdecode(b"\xff.yaml")
    (project / name).write_text(TASK)
    assert main(["run", name, "--robot", "fake", "--in-process"]) == 0
    assert main(["runs", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (found["status"], found["task_path"][-9:]) == ("success", "\\xff.yaml")


def test_the_last_name_of_a_path_is_enough_to_be_told_the_whole(project, capsys):
    (project / "t.yaml").write_text(
        "grip: 1\nname: t\nroot:\n  kind: retry\n  times: 2\n  child:\n    deep_inside:\n"
        "      kind: sequence\n      children: {x: {node: flow/succeed}}\n"
    )
    assert run("--mock", "x=failure") == 1
    assert "unknown node 'x'; did you mean 'deep_inside/x'?" in capsys.readouterr().err
