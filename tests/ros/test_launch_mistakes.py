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
            f"<node>: the attribute 'executable' {UNKNOWN[:-2]} (supported: args, cwd, emulate_tty, exec, if",
        ),
        ('<node package="a" exec="b"/>', f"<node>: the attribute 'package' {UNKNOWN}did you mean 'pkg'"),
        (NODE % ' arguments="--fast"', "did you mean 'args'"),
        (NODE % ' ros_arguments="1"', "did you mean 'ros_args'"),
        (NODE % ' launch_prefix="gdb"', "did you mean 'launch-prefix'"),
        (NODE % ' parameters="a"', "unless; inside of it: <param>, <remap>, <env>)"),
        (NODE % ' args="\'a"', 'args: a quotation mark is missing in "\'a"'),
        (NODE % ' respawn="yes"', "`respawn` is true, false, 1 or 0, not 'yes'"),
        ('<node exec="b"/>', "<node> needs the attribute 'pkg'"),
        (
            WITH % '<parameter name="a" value="b"/>',
            "<parameter> can't stand in <node> here; did you mean 'param'? (available",
        ),
        (WITH % '<remapping from="a" to="b"/>', "can't stand in <node> here; did you mean 'remap'"),
        (WITH % '<remap name="a" value="b"/>', "the attribute 'name' is not supported (supported: from, to)"),
        (WITH % '<param name="a" value="b" typ="str"/>', "'typ' is not supported; did you mean 'type'"),
        (WITH % '<param name="a" value="b" type="string"/>', "<param type='string'> is not supported (supported: int"),
        (WITH % '<param name="a">3</param>', "<param> needs the attribute 'value'"),
        (WITH % '<param name="g"><param name="a" vlaue="b"/></param>', "did you mean 'value'"),
        ('<param name="a" value="b"/>', f"<param> {UNKNOWN}it stands in <node> or <param>"),
        ('<remap from="a" to="b"/>', "it stands in <node> (supported"),
        ('<setenv name="a" value="b"/>', "did you mean 'set_env'"),
        ('<arg name="a" choices="b"/>', "inside of it: <choice>)"),
        ('<push_ros_namespace ns="a"/>', "(supported: if, namespace, unless)"),
        (f'<include file="{INNER[:-10]}lanch.xml"/>', "did you mean 'inner.launch.xml'? (launch files there: inner.l"),
        ('<executable cmd="ls" if="a == b"/>', "texts are compared by $(equals $(var NAME) VALUE)"),
        ('<executable cmd="$(sim)"/>', "unknown substitution $(sim ...); the value of an argument is $(var sim)"),
        ('<executable cmd="$(var sim)"/>', "$(var sim): there is none; a default: $(var sim VALUE)"),
        ('<executable cmd="$(eval sim)"/>', "'sim' is no value; a text stands in quotation marks"),
        ("<node pkg=a/>", "isn't well-formed XML"),
    ],
)
def test_what_to_write_instead_is_told(told, text, said):
    assert said in told(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("- node: {package: a, executable: b}", f"'package' {UNKNOWN}did you mean 'pkg'"),
        ("- node: {pkg: a, exec: b, params: [{name: c}]}", "`node`: `params` is one text"),
        ("- node: {pkg: a, exec: b, param: {name: c, value: d}}", "`node`: `param` is a list of mappings"),
        ("- node: {pkg: a, exec: b, param: [{c: d}]}", "the attribute 'c' is not supported (supported: allow_substs,"),
        ("- node: {pkg: a, exec: b, remap: ['c:=d']}", "`remap` holds a mapping without dashes, such as `- node: {"),
        ("- node: {pkg: a, exec: b, args: [--c, d]}", "`node`: `args` is one text"),
        ("- pkg: a\n  exec: b", "each item is one `tag: {...}`, such as `- node: {pkg: P, exec: X}`"),
    ],
)
def test_so_it_is_in_yaml(told, text, said):
    assert said in told(text, "it.launch.yaml")


@pytest.mark.parametrize("text", ["- node: {pkg: a}", "launch: {node: {pkg: a}}"])
def test_a_yaml_file_of_another_shape_is_told_the_shape(tmp_path, text):
    (tmp_path / "a.launch.yaml").write_text(text)
    with pytest.raises(LaunchError, match=r"`- node: \{pkg: P, exec: X\}`"):
        read_launch_file(tmp_path / "a.launch.yaml")


@pytest.mark.parametrize("text", ["", "<launch/><launch/>"])
def test_so_is_an_xml_file_of_another_shape(tmp_path, text):
    (tmp_path / "a.launch.xml").write_text(text)
    with pytest.raises(LaunchError, match="isn't well-formed XML"):
        read_launch_file(tmp_path / "a.launch.xml")


def test_substitutions_in_a_file_of_parameters_are_refused_not_left_out(tmp_path, prefix):
    (tmp_path / "p.yaml").write_text("/**: {ros__parameters: {a: $(var b)}}\n")
    file = tmp_path / "a.launch.xml"
    node = '<param from="$(dirname)/p.yaml" allow_substs="%s"/>'
    file.write_text(f"<launch>{WITH % node % 'true'}</launch>")
    with pytest.raises(LaunchError, match="substitutions in a file of parameters aren't made here"):
        read_launch_file(file)
    file.write_text(f"<launch>{WITH % node % 'false'}</launch>")
    assert "--params-file" in read_launch_file(file)[0].command
