"""`grip convert --to bt|sm` says how the two forms compare."""

import pytest

from grip_bt.cli.__main__ import main

TEXT = """\
grip: 1
name: a
root:
  kind: sequence
  memory: false
  children:
    look: {node: flow/succeed}
    arm: {node: flow/wait, with: {seconds: 1}}
"""


@pytest.fixture
def task(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(TEXT)
    return path


def test_an_exact_conversion_says_that_it_was_compared(task, capsys):
    assert main(["convert", str(task), "--to", "sm"]) == 0
    said = capsys.readouterr()
    assert "kind: sequence" in said.out
    assert "exact by construction, and the same in" in said.err


def test_an_approximate_one_shows_a_script_with_which_it_differs(task, capsys):
    assert main(["convert", str(task), "--to", "sm", "--approximate"]) == 0
    said = capsys.readouterr()
    assert "kind: state_machine" in said.out
    assert "not the same: with leaves that end like this:\n  look: success\n  look: success\n" in said.err
    assert said.err.endswith("step 2 before: look: success\nstep 2 after: arm: success after a tick\n")
    assert "exact" not in said.err


def test_only_machines_are_approximated(task):
    with pytest.raises(SystemExit) as caught:
        main(["convert", str(task), "--to", "bt", "--approximate"])
    assert caught.value.code == 2
