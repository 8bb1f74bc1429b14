"""An installed demonstration works in the user's own folders, and never in those of the installation."""

import shutil
from pathlib import Path

import pytest

import grip_bt
from grip_bt.base.errors import MissingPartError, NotWritableError
from grip_bt.cli.demo import examples_folder

CLONE = Path(__file__).parents[2] / "examples"


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Return the folder of an installed package that carries the examples."""
    package = tmp_path / "site-packages" / "grip_bt"
    shutil.copytree(CLONE, package / "_examples", ignore=shutil.ignore_patterns(".grip", "__pycache__"))
    monkeypatch.setattr(grip_bt, "__file__", str(package / "__init__.py"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return package


def test_a_clone_works_in_its_own_examples():
    assert examples_folder() == CLONE


def test_an_installation_works_in_a_copy_that_keeps_what_was_changed(installed, tmp_path):
    copy = examples_folder()
    assert copy.parent == tmp_path / "data" / "grip"
    assert (copy / "tasks" / "reactive_pick.yaml").read_bytes() == (CLONE / "tasks/reactive_pick.yaml").read_bytes()
    (copy / "grip.yaml").write_text("grip: 1\n")
    assert examples_folder() == copy
    assert (copy / "grip.yaml").read_text() == "grip: 1\n"
    assert [each.name for each in copy.parent.iterdir()] == [copy.name]


def test_the_copy_of_a_read_only_installation_may_be_written_to(installed):
    for path in (installed, *installed.rglob("*")):
        path.chmod(path.stat().st_mode & ~0o222)
    copy = examples_folder()
    assert all(path.stat().st_mode & 0o200 for path in (copy, *copy.rglob("*")))


def test_another_version_of_the_examples_is_another_copy(installed):
    before = examples_folder()
    (installed / "_examples" / "tasks" / "new.yaml").write_text("grip: 1\n")
    assert examples_folder() != before
    assert (examples_folder() / "tasks" / "new.yaml").is_file()


def test_where_nothing_can_be_written_or_copied_it_is_said(installed, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "file"))
    with pytest.raises(NotWritableError, match="set XDG_DATA_HOME"):
        examples_folder()
    shutil.rmtree(installed / "_examples")
    with pytest.raises(MissingPartError):
        examples_folder()
