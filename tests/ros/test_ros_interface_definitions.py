"""Interface files are read by rosidl's parser, and what is wrong is told with its line."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from grip_bt.base.errors import DocumentError, MissingPartError
from grip_bt.ros.interfaces import (
    InterfaceBuildError,
    build_interfaces,
    content_hash,
    find_packages,
    parse_interface,
    read_interface,
)
from grip_bt.ros.interfaces.generate import _working
from grip_bt.task.catalog.ros_config import FieldSpec

PACKAGE_XML = "<package format='3'><name>{name}</name>{depends}</package>"


def make_package(folder: Path, name: str, files: dict[str, str], depends: tuple[str, ...] = ()) -> Path:
    home = folder / name
    home.mkdir(parents=True)
    depends_xml = "".join(f"<depend>{d}</depend>" for d in depends)
    (home / "package.xml").write_text(PACKAGE_XML.format(name=name, depends=depends_xml))
    for path, text in files.items():
        (home / path).parent.mkdir(exist_ok=True)
        (home / path).write_text(text)
    return home


def test_a_service_is_read_with_types_bounds_and_comments():
    spec = parse_interface(
        "# What it does.\n\nPoint[<=3] input  # where [m]\nfloat64[9] k\nint32 N=3\n"
        "---\nstring<=5 note\nint8 outcome\n",
        "my_pkg",
        "srv",
        "Do",
    )
    assert spec.doc == "What it does."
    assert spec.type_name == "my_pkg/srv/Do"
    assert spec.request == (
        FieldSpec("input", "my_pkg/msg/Point", True, 3, True, "where [m]"),
        FieldSpec("k", "float64", True, 9),
    )
    assert [f.spelling for f in spec.request] == ["my_pkg/Point[<=3]", "float64[9]"]
    assert [f.name for f in spec.response if f.is_integer] == ["outcome"]


def test_an_installed_type_is_read_by_its_name():
    spec = read_interface("std_srvs/srv/SetBool")
    assert [(f.type, f.name) for f in spec.request] == [("bool", "data")]
    assert [f.name for f in spec.response] == ["success", "message"]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("std_srvs/srv/SetBol", "did you mean 'SetBool'"),
        ("no_such_pkg/srv/Do", "no package 'no_such_pkg'"),
        ("nonsense", "neither a .msg, .srv or .action file nor a type"),
    ],
)
def test_an_unknown_type_is_named(name, told):
    with pytest.raises(DocumentError, match=told):
        read_interface(name)


@pytest.mark.parametrize(
    ("text", "line", "told"),
    [
        ("int32 a\nfloat64\n---\n", 2, "a field is written as 'type name'"),
        ("int32 a\n---\nint32 Bad\n", 3, "'Bad'"),
        ("int32 a\n---\nint32 b\nint32 c\nint32 b\n", 5, "b"),
        ("int32 A=1\nint32 A=2\n---\n", 2, "A"),
        ("float64 w=1.5\n---\n", 1, "'w'"),
        ("a/b/c d\n---\n", 1, "isn't a type"),
        ("# a comment\nuint8 a 300\n---\n", 2, "300"),
        ("int32[0] a\n---\n", 1, "size of array"),
        ("", 1, "one line with just '---', this one has 0"),
        ("int32 a\n", 1, "one line with just '---', this one has 0"),
        ("int32 a\n---\nint32 b\n---\n", 4, "one line with just '---', this one has 2"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(text, line, told):
    with pytest.raises(DocumentError) as caught:
        parse_interface(text, "my_pkg", "srv", "Do", "Do.srv")
    assert caught.value.line == line
    assert told in str(caught.value)
    assert str(caught.value).startswith(f"Do.srv:{line}: ")


@pytest.mark.parametrize(
    ("field", "told"),
    [
        ("sensor_mgs/Image input", "there is no package 'sensor_mgs'"),
        ("sensor_msgs/Imagee input", "did you mean 'Image'"),
        ("Graps input", "did you mean 'Grasp'"),
        (
            "int32 class",
            "field 'class': it is a keyword of Python; rename it, for example to 'class_value'",
        ),
        ("int32 in", "it is a keyword of Python"),
        ("duration input", "'duration' is of ROS 1; ROS 2 has builtin_interfaces/Duration"),
        ("Header header", "ROS 2 has std_msgs/Header, for which package.xml has to ask: <depend>std_msgs</depend>"),
    ],
)
def test_a_build_names_the_line_that_asks_for_a_type_that_is_not_there(tmp_path, field, told):
    home = make_package(
        tmp_path, "my_pkg", {"msg/Grasp.msg": "int32 a\n", "srv/Do.srv": f"int32 a\n{field}\n---\nint32 outcome\n"}
    )
    with pytest.raises(DocumentError, match=told) as caught:
        build_interfaces(home, tmp_path / "cache")
    assert (caught.value.line, Path(caught.value.source).name) == (2, "Do.srv")


@pytest.mark.parametrize(
    ("data", "line", "told"),
    [
        (b"int32 a\n# caf\xe9\n", 2, "isn't UTF-8 text: byte 0xe9"),
        (b"\xef\xbb\xbfint32 a\n", 1, "a byte order mark"),
    ],
)
def test_a_file_that_is_no_plain_text_is_told(tmp_path, data, line, told):
    home = make_package(tmp_path, "my_pkg", {"msg/A.msg": ""})
    (home / "msg" / "A.msg").write_bytes(data)
    for read in (lambda: build_interfaces(home, tmp_path / "cache"), lambda: read_interface(home / "msg" / "A.msg")):
        with pytest.raises(DocumentError, match=told) as caught:
            read()
        assert (caught.value.line, Path(caught.value.source).name) == (line, "A.msg")


def test_a_package_beside_has_to_be_asked_for(tmp_path):
    make_package(tmp_path, "base_pkg", {"msg/A.msg": "int32 a\n"})
    make_package(tmp_path, "a_uses_base", {"msg/B.msg": "base_pkg/A a\n"})
    with pytest.raises(DocumentError, match="package.xml has to ask for 'base_pkg': <depend>base_pkg</depend>"):
        build_interfaces(tmp_path, tmp_path / "cache")


@pytest.mark.parametrize(
    ("path", "told"), [("nowhere", "no such folder"), ("my_pkg/msg/A.msg", "is a file"), ("bare", "package.xml is")]
)
def test_what_is_no_folder_with_packages_is_told(tmp_path, path, told):
    make_package(tmp_path, "my_pkg", {"msg/A.msg": "int32 a\n"})
    (tmp_path / "bare" / "msg").mkdir(parents=True)
    with pytest.raises(DocumentError, match=told):
        find_packages(tmp_path / path)


def test_a_generator_that_ends_the_process_is_an_error_with_what_it_said(capfd):
    def ends():
        sys.stderr.write("KeyError processing template\n")
        sys.exit(1)

    with pytest.raises(InterfaceBuildError, match="my_pkg: the interface generator failed:\nKeyError processing"):
        with _working("my_pkg", []):
            ends()
    assert capfd.readouterr() == ("", "")


def test_packages_come_after_those_that_they_need(tmp_path):
    make_package(tmp_path, "a_uses_b", {"msg/A.msg": "int32 a\n"}, ("b_uses_c",))
    make_package(tmp_path, "b_uses_c", {"msg/B.msg": "int32 a\n"}, ("c_alone",))
    make_package(tmp_path, "c_alone", {"msg/C.msg": "int32 a\n"}, ("sensor_msgs",))
    assert [p.name for p in find_packages(tmp_path)] == ["c_alone", "b_uses_c", "a_uses_b"]


def test_packages_in_a_circle_are_refused(tmp_path):
    make_package(tmp_path, "a_pkg", {"msg/A.msg": "int32 a\n"}, ("b_pkg",))
    make_package(tmp_path, "b_pkg", {"msg/B.msg": "int32 a\n"}, ("a_pkg",))
    with pytest.raises(DocumentError, match="circle"):
        find_packages(tmp_path)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<package><name>x</name>", "well-formed"),
        ("<package/>", "<name> is missing"),
        (None, "none is in here; an interface package is a folder with package.xml and msg/, srv/ or action/"),
        ("<package><name>MyMsgs</name></package>", "<name> is 'MyMsgs': lower case letters"),
    ],
)
def test_a_broken_package_is_named(tmp_path, text, told):
    (tmp_path / "p" / "msg").mkdir(parents=True)
    (tmp_path / "p" / "msg" / "A.msg").write_text("int32 a\n")
    if text is not None:
        (tmp_path / "p" / "package.xml").write_text(text)
    with pytest.raises(DocumentError, match=told):
        build_interfaces(tmp_path, tmp_path / "cache")


def test_the_hash_follows_the_content_of_the_files_and_of_what_they_need(tmp_path):
    home = make_package(tmp_path, "my_pkg", {"msg/A.msg": "int32 a\n"})
    (package,) = find_packages(home)
    before = content_hash(package)
    assert content_hash(package) == before
    assert content_hash(package, ["other"]) != before
    (home / "msg" / "A.msg").write_text("int64 a\n")
    assert content_hash(package) != before


def test_a_missing_compiler_is_named_with_what_mends_it(tmp_path, monkeypatch):
    home = make_package(tmp_path, "my_pkg", {"msg/A.msg": "int32 a\n"})
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingPartError, match=r"gcc.*apt install g\+\+"):
        build_interfaces(home, tmp_path / "cache")
