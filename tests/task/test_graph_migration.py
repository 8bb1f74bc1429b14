"""Files of other versions: newer ones are refused and say so, older ones are read over text-preserving steps."""

import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.task import dumps, fmt, loads, migration, read_text

OLD = """\
# a file of before
grip: 0
name: a
root:
  kind: selector  # was called so
  children:
    # first
    b: {node: a/b}
"""
NEW = OLD.replace("grip: 0", "grip: 1").replace("kind: selector ", "kind: fallback ")


def to_one(text):
    return text.replace("grip: 0", "grip: 1", 1).replace("kind: selector", "kind: fallback")


def test_an_older_file_is_read_as_it_is_and_written_in_the_new_format_with_its_comments(monkeypatch):
    monkeypatch.setattr(migration, "STEPS", {0: to_one})
    document = read_text(OLD)
    assert (document.text, document.written_as) == (NEW, 0)
    assert document.task == loads(NEW)
    assert read_text(NEW).written_as == 1
    assert fmt(OLD) == fmt(NEW)
    assert "# a file of before" in fmt(OLD)
    assert "# was called so" in fmt(OLD)
    assert fmt(fmt(OLD)) == fmt(OLD)
    assert dumps(document.task).startswith("grip: 1\n")


def test_steps_follow_each_other(monkeypatch):
    steps = {-1: lambda text: text.replace("grip: -1", "grip: 0").replace("choose", "selector"), 0: to_one}
    monkeypatch.setattr(migration, "STEPS", steps)
    assert read_text(OLD.replace("grip: 0", "grip: -1").replace("selector", "choose")).text == NEW


def test_what_is_wrong_in_an_older_file_is_said_as_of_the_new_one(monkeypatch):
    monkeypatch.setattr(migration, "STEPS", {0: to_one})
    with pytest.raises(DocumentError, match=r":5:9: unknown kind 'selektor' "):
        loads(OLD.replace("selector", "selektor"))


@pytest.mark.parametrize(
    ("version", "words"),
    [
        ("2", "t.yaml:2:7: a file of the newer format 2; this grip reads up to `grip: 1`: update it"),
        ("0", "t.yaml:2:7: a file of the format 0; the oldest that is read is `grip: 1`"),
        ("'1'", "t.yaml:2:1: grip: the version of the format is a whole number, `grip: 1`, not '1'"),
    ],
)
def test_other_versions_are_refused_with_what_to_do(version, words):
    with pytest.raises(DocumentError, match=words):
        read_text(NEW.replace("grip: 1", f"grip: {version}"), "t.yaml")
