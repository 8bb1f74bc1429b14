"""Mistakes that are usual in launch files are refused with the line and with what to write instead."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.ros.launch import LaunchError, read_launch_file


@pytest.fixture
def prefix(tmp_path, monkeypatch) -> Path:
    """Return a prefix, where packages are looked for, with one package that has one program and one launch file."""
    root = tmp_path / "prefix"
    program = root / "lib" / "arm_driver" / "driver"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    share = root / "share" / "arm_driver" / "launch"
    share.mkdir(parents=True)
    (share / "inner.launch.xml").write_text("<launch/>")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(root))
    return root


@pytest.fixture
def told(tmp_path, prefix):
    """Return a function that reads elements from line 2 of a launch file, and returns what is said of them."""

    def read(text: str, name: str = "it.launch.xml") -> str:
        file = tmp_path / name
        file.write_text(f"launch:\n{text}\n" if name.endswith("yaml") else f"<launch>\n{text}\n</launch>")
        with pytest.raises(LaunchError) as caught:
            read_launch_file(file)
        where, line, reason = str(caught.value).split(":", 2)
        assert (Path(where).name, line) == (name, "2")
        return reason.strip()

    return read


NODE = '<node pkg="arm_driver" exec="driver"%s/>'
WITH = '<node pkg="arm_driver" exec="driver">%s</node>'
UNKNOWN = "is not supported; "
INNER = "$(find-pkg-share arm_driver)/launch/inner.launch.xml"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            '<node pkg="a" executable="b"/>',
            f"<node>: the attribute 'executable' {UNKNOWN}write 'exec' (supported: args",
        ),
        ('<node package="a" exec="b"/>', f"<node>: the attribute 'package' {UNKNOWN}write 'pkg'"),
        (
            '<node package="a" executable="b"/>',
            f"'package' {UNKNOWN}write 'pkg', and 'executable' {UNKNOWN}write 'exec' (supported: args",
        ),
        ('<node package="a" plugin="b"/>', "a plugin is a library for a container"),
        (NODE % ' arguments="--fast"', "write 'args'"),
        (NODE % ' condition="1"', "write 'if'"),
        (NODE % ' ros_arguments="1"', "write 'ros_args'"),
        (NODE % ' launch_prefix="gdb"', "did you mean 'launch-prefix'"),
        (NODE % ' parameters="a"', 'an element in <node>: <param name="NAME" value="VALUE"/>; of a file: <param from'),
        (NODE % ' remappings="a:=b"', 'that is an element in <node>: <remap from="NAME" to="OTHER"/>'),
        (NODE % ' env="A=b"', 'that is an element in <node>: <env name="NAME" value="VALUE"/>'),
        (NODE % ' log_level="debug"', 'write ros_args="--log-level LEVEL"'),
        (NODE % ' args="\'a"', 'args: a quotation mark is missing in "\'a"'),
        (NODE % ' output="scren"', "output is one of screen, log, both, own_log, full, not 'scren'; did you mean 'scr"),
        (NODE % ' respawn="yes"', "`respawn` is true, false, 1 or 0, not 'yes'"),
        ('<node exec="b"/>', '<node> needs the attribute \'pkg\', such as <node pkg="PACKAGE" exec="PROGRAM"/>'),
        ('<Node pkg="a" exec="b"/>', f'<Node> {UNKNOWN}write <node pkg="PACKAGE" exec="PROGRAM"/>'),
        (WITH % '<parameter name="a" value="b"/>', '<parameter> can\'t stand in <node> here; write <param name="NAME"'),
        (WITH % '<remapping from="a" to="b"/>', 'can\'t stand in <node> here; write <remap from="NAME" to="OTHER"/>'),
        (WITH % '<arg name="a"/>', "<arg> can't stand in <node> here; the arguments of its program are the attribute"),
        (WITH % '<remap name="a" value="b"/>', f"'name' {UNKNOWN}write 'from', and 'value' {UNKNOWN}write 'to'"),
        (WITH % '<remap src="a" dst="b"/>', f"'src' {UNKNOWN}write 'from', and 'dst' {UNKNOWN}write 'to'"),
        (WITH % '<param key="a" val="b"/>', f"'key' {UNKNOWN}write 'name', and 'val' {UNKNOWN}write 'value'"),
        (WITH % '<param file="a.yaml"/>', "the attribute 'file' is not supported; write 'from'"),
        (WITH % '<param name="a" value="b" typ="str"/>', "'typ' is not supported; did you mean 'type'"),
        (
            WITH % '<param name="a" value="b" type="string"/>',
            "<param type='string'> is not supported; write 'str'",
        ),
        (WITH % '<param name="a" value="b" if="0"/>', "give the <node> twice, each with its condition"),
        (WITH % '<param name="a">3</param>', "<param> needs the attribute 'value', such as <param name=\"NAME\""),
        (WITH % '<param name="g"><param name="a" vlaue="b"/></param>', "did you mean 'value'"),
        (WITH % '<env var="a" value="b"/>', "write 'name'"),
        (
            '<param name="a" value="b"/>',
            "it stands in the <node> whose parameter it is; for all nodes that follow: <se",
        ),
        ('<remap from="a" to="b"/>', "it stands in the <node> whose name it changes; for all nodes that follow: <set"),
        ('<env name="a" value="b"/>', "for all that follow: <set_env name= value=>"),
        ('<setenv name="a" value="b"/>', 'write <set_env name="NAME" value="VALUE"/>'),
        ('<argument name="a"/>', 'write <arg name="NAME" default="VALUE"/>'),
        ('<arg name="a" choices="b"/>', 'that is an element in <arg>: <choice value="VALUE"/>'),
        ('<let name="a" default="b"/>', "write 'value'"),
        ('<group namespace="a"/>', "a <push_ros_namespace namespace=...> as the first element of the group does that"),
        ('<namespace value="a"/>', 'write <push_ros_namespace namespace="NAME"/>'),
        ('<push_ros_namespace ns="a"/>', "write 'namespace'"),
        ('<include pkg="arm_driver" file="inner.launch.xml"/>', "part of `file`: $(find-pkg-share PACKAGE)/launch/FI"),
        (f'<include file="{INNER}"><param name="a" value="b"/></include>', 'given by <arg name="NAME" value="VALUE"/>'),
        (f'<include file="{INNER}"><arg name="a" default="b"/></include>', "write 'value'"),
        (f'<include file="{INNER}"><arg name="a"/></include>', 'such as <arg name="NAME" value="VALUE"/>'),
        (f'<include file="{INNER[:-10]}lanch.xml"/>', "did you mean 'inner.launch.xml'? (launch files there: inner.l"),
        ('<executable exec="ls"/>', "write 'cmd'"),
        ('<executable cmd="a" args="b"/>', "the arguments are part of `cmd`"),
        ('<process cmd="ls"/>', 'write <executable cmd="PROGRAM ARGUMENTS"/>'),
        ('<timer seconds="3"/>', "write 'period'"),
        ('<log text="a"/>', "write 'message'"),
        ('<log level="loud" message="a"/>', "level is one of debug, info, warning, warn, error, critical, not 'loud'"),
        ('<shutdown message="a"/>', "write 'reason'"),
        ('<executable cmd="ls" if="$sim"/>', "`if` is true, false, 1 or 0, not '$sim'; a variable is $(var NAME)"),
        ('<executable cmd="ls" if="a == b"/>', "texts are compared by $(equals $(var NAME) VALUE)"),
        ('<executable cmd="$(sim)"/>', "unknown substitution $(sim ...); the value of an argument is $(var sim)"),
        ('<executable cmd="$(var sim)"/>', "no such argument; one is declared by <arg> or <let>, before it is used"),
        ("<node pkg=a/>", 'each attribute is NAME="VALUE" in quotation marks, and in it & is written &amp;'),
    ],
)
def test_what_to_write_instead_is_told(told, text, said):
    assert said in told(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "- node: {package: a, executable: b}",
            f"'package' {UNKNOWN}write 'pkg', and 'executable' {UNKNOWN}write 'exec'",
        ),
        (
            "- node: {pkg: a, exec: b, params: [{name: c}]}",
            "it is a list: `param: [{name: NAME, value: VALUE}]`; of a f",
        ),
        (
            "- node: {pkg: a, exec: b, param: {name: c, value: d}}",
            "`node`: `param` can't be given like this; it is a list",
        ),
        (
            "- node: {pkg: a, exec: b, param: [{c: d}]}",
            "the attribute 'c' is not supported (supported: allow_substs,",
        ),
        ("- node: {pkg: a, exec: b, remap: ['c:=d']}", "`remap` holds a mapping, such as {from: NAME, to: OTHER}"),
        ("- node: {pkg: a, exec: b, args: [--c, d]}", "`node`: `args` can't be given like this; it is one text"),
        ("- node: {pkg: a, exec: b, env: {C: d}}", "it is a list: `env: [{name: NAME, value: VALUE}]`"),
        ("- node: {exec: b}", "<node> needs the attribute 'pkg', such as {pkg: PACKAGE, exec: PROGRAM}"),
        (
            "- node:\n  - pkg: a\n  - exec: b",
            "`node` holds a mapping without dashes, such as {pkg: PACKAGE, exec: PROGRAM}",
        ),
        (
            "- pkg: a\n  exec: b",
            "each item is one `tag: {...}`, such as `- node: {pkg: P, exec: X}`; what belongs to it",
        ),
        ("- Node: {pkg: a, exec: b}", "write `node`: {pkg: PACKAGE, exec: PROGRAM}"),
        ("- include: a.yaml", "`include` holds a mapping, such as {file: $(find-pkg-share PACKAGE)/launch/FILE}"),
        ("- arg: {name: a, choices: [b, c]}", "it is a list: `choice: [{value: VALUE}]`"),
    ],
)
def test_so_it_is_in_yaml(told, text, said):
    assert said in told(text, "it.launch.yaml")


@pytest.mark.parametrize("text", ["- node: {pkg: a}", "launch: {node: {pkg: a}}"])
def test_a_yaml_file_of_another_shape_is_told_the_shape(tmp_path, text):
    (tmp_path / "a.launch.yaml").write_text(text)
    with pytest.raises(LaunchError, match=r"`- node: \{pkg: P, exec: X\}`"):
        read_launch_file(tmp_path / "a.launch.yaml")


@pytest.mark.parametrize(
    ("text", "said"),
    [("", "it begins with <launch> and ends with </launch>"), ("<launch/><launch/>", "in one <launch>")],
)
def test_so_is_an_xml_file_of_another_shape(tmp_path, text, said):
    (tmp_path / "a.launch.xml").write_text(text)
    with pytest.raises(LaunchError, match=said):
        read_launch_file(tmp_path / "a.launch.xml")


def test_substitutions_in_a_file_of_parameters_are_refused_not_left_out(tmp_path, prefix):
    (tmp_path / "p.yaml").write_text("/**: {ros__parameters: {a: $(var b)}}\n")
    file = tmp_path / "a.launch.xml"
    node = '<param from="$(dirname)/p.yaml" allow_substs="%s"/>'
    file.write_text(f"<launch>{WITH % node % 'true'}</launch>")
    with pytest.raises(LaunchError, match="substitutions in a file of parameters aren't made here"):
        read_launch_file(file)
    file.write_text(f"<launch>{WITH % node % 'false'}</launch>")
    assert "--params-file" in read_launch_file(file).processes[0].command
