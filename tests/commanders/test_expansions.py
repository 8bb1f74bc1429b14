"""Expanded xacro files are kept until one of the files that they were made of changes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.commanders.description import xacro_files
from grip_bt.commanders.description.files import noting_files
from grip_bt.commanders.description.packages import Packages

OUTER = (
    '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="n" default="a"/>'
    '<xacro:include filename="inner.xacro"/><xacro:link_of n="$(arg n)"/></robot>'
)
INNER = (
    '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="link_of" params="n">'
    '<link name="WORD_${n}"/></xacro:macro></robot>'
)


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "inner.xacro").write_text(INNER)
    (tmp_path / "outer.xacro").write_text(OUTER)
    return tmp_path / "outer.xacro"


def expand(file: Path, **arguments: object) -> str:
    return xacro_files.expand(file, arguments, Packages({}))


def no_process(*_: object, **__: object) -> None:
    raise AssertionError("a process was started")


def test_a_second_time_no_process_is_started_and_the_files_are_still_known(file, monkeypatch):
    first = expand(file, n="b")
    monkeypatch.setattr(xacro_files.subprocess, "run", no_process)
    with noting_files() as files:
        assert expand(file, n="b") == first
    assert {f.name for f in files} == {"outer.xacro", "inner.xacro"}
    assert "WORD_b" in first


def test_other_arguments_are_another_text(file):
    assert "WORD_b" in expand(file, n="b")
    assert "WORD_c" in expand(file, n="c")


@pytest.mark.parametrize("changed", ["outer.xacro", "inner.xacro"])
def test_a_file_that_changes_is_expanded_anew(file, changed):
    expand(file)
    path = file.parent / changed
    path.write_text(path.read_text().replace('"r"', '"other"').replace("WORD", "NEWER"))
    assert "other" in expand(file) or "NEWER_a" in expand(file)


def test_a_wrong_file_is_not_kept(file):
    file.write_text("<robot")
    for _ in range(2):
        with pytest.raises(DocumentError):
            expand(file)
    assert not list(file.parent.glob("cache/**/*.json"))


def test_what_is_damaged_or_too_much_goes(file, monkeypatch):
    monkeypatch.setattr(xacro_files, "MOST", 2)
    for n in "abcd":
        text = expand(file, n=n)
    kept = list(file.parent.glob("cache/**/*.json"))
    assert len(kept) == 2
    for entry in kept:
        entry.write_text("{")
    assert expand(file, n="d") == text


def test_where_nothing_can_be_written_it_is_expanded_each_time(file, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", os.devnull)
    assert expand(file) == expand(file)
