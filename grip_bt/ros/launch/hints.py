"""What is written by mistake in launch files (such as names of Python launch files), and what to write instead."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from grip_bt.base.errors import listing, nearest

_ATTRIBUTES = {
    **dict.fromkeys(("executable", "program", "exe", "node_executable"), ("exec", "cmd")),
    **dict.fromkeys(("package", "node_package"), ("pkg",)),
    **dict.fromkeys(("exec", "command"), ("cmd", "exec")),
    "arguments": ("args",),
    "ros_arguments": ("ros_args",),
    **dict.fromkeys(("node_name", "key", "var", "variable"), ("name",)),
    **dict.fromkeys(("ns", "node_namespace", "value"), ("namespace", "to")),
    "name": ("namespace", "from"),
    **dict.fromkeys(("src", "source", "old"), ("from",)),
    **dict.fromkeys(("dst", "dest", "target", "new"), ("to",)),
    **dict.fromkeys(("val", "default"), ("value",)),
    **dict.fromkeys(("file", "filename", "path"), ("filename", "file", "from")),
    "launch": ("file",),
    **dict.fromkeys(("seconds", "delay"), ("period",)),
    **dict.fromkeys(("text", "msg"), ("message",)),
    "message": ("reason",),
    "condition": ("if",),
    "doc": ("description",),
}
"""An attribute that is written -> those that may be meant; the first that the element has is."""
_IN_PLACE = {
    ("node", ("param", "params", "parameter", "parameters")): "param",
    ("node", ("remap", "remaps", "remapping", "remappings")): "remap",
    ("node", ("env", "environment", "additional_env")): "env",
    ("executable", ("env", "environment", "additional_env")): "env",
    ("arg", ("choice", "choices")): "choice",
    ("include", ("arg", "args", "arguments", "launch_arguments")): "arg",
}
"""What is written as an attribute, and is an element of its own."""
_INSTEAD = {
    ("node", "plugin"): "a plugin is a library for a container; its package mostly has the same as a program: exec",
    ("node", "log_level"): 'write ros_args="--log-level LEVEL"',
    ("executable", "args"): "the arguments are part of `cmd`",
    ("executable", "required"): 'write on_exit="shutdown"',
    ("group", "namespace"): "a <push_ros_namespace namespace=...> as the first element of the group does that",
    ("include", "pkg"): "the package is part of `file`: $(find-pkg-share PACKAGE)/launch/FILE",
    ("include", "package"): "the package is part of `file`: $(find-pkg-share PACKAGE)/launch/FILE",
    ("include", "namespace"): "a <group> around the include, with a <push_ros_namespace namespace=...>, does that",
    **dict.fromkeys((("param", "if"), ("param", "unless")), "give the <node> twice, each with its condition"),
    **dict.fromkeys((("remap", "if"), ("remap", "unless")), "give the <node> twice, each with its condition"),
}
_TAGS = {
    **dict.fromkeys(("parameter", "parameters", "params"), ("param", "set_parameter")),
    **dict.fromkeys(("remapping", "remappings", "remaps"), ("remap", "set_remap")),
    **dict.fromkeys(("argument", "arguments", "args", "declare_argument"), ("arg",)),
    **dict.fromkeys(("exec", "process", "execute_process", "program", "command"), ("executable",)),
    **dict.fromkeys(("environment", "setenv"), ("env", "set_env")),
    **dict.fromkeys(("namespace", "push_namespace", "ns"), ("push_ros_namespace",)),
    "choices": ("choice",),
    "Node": ("node",),
}
"""A tag that is written -> those that may be meant; the first that can stand there is."""
_OUTSIDE = {
    "param": "stands in the <node> whose parameter it is; for all nodes that follow: <set_parameter name= value=>",
    "remap": "stands in the <node> whose name it changes; for all nodes that follow: <set_remap from= to=>",
    "env": "stands in a <node> or <executable>; for all that follow: <set_env name= value=>",
    "choice": "stands in the <arg> whose values it limits",
}
_FORMS = {
    "node": (("pkg", "PACKAGE"), ("exec", "PROGRAM")),
    "param": (("name", "NAME"), ("value", "VALUE")),
    "remap": (("from", "NAME"), ("to", "OTHER")),
    "env": (("name", "NAME"), ("value", "VALUE")),
    "arg": (("name", "NAME"), ("default", "VALUE")),
    "let": (("name", "NAME"), ("value", "VALUE")),
    "choice": (("value", "VALUE"),),
    "include": (("file", "$(find-pkg-share PACKAGE)/launch/FILE"),),
    "executable": (("cmd", "PROGRAM ARGUMENTS"),),
    "set_env": (("name", "NAME"), ("value", "VALUE")),
    "set_remap": (("from", "NAME"), ("to", "OTHER")),
    "set_parameter": (("name", "NAME"), ("value", "VALUE")),
    "set_use_sim_time": (("value", "true"),),
    "push_ros_namespace": (("namespace", "NAME"),),
    "timer": (("period", "SECONDS"),),
}


TYPES = {"string": "str", "double": "float", "boolean": "bool", "integer": "int", "long": "int"}
"""Types of parameters, as other languages call them -> as they are called here."""


def form(tag: str, yaml: bool, given: bool = False) -> str:
    """Return how an element is written, or an empty string where nobody knows.

    Args:
        tag: the element's.
        yaml: whether as YAML, not as XML.
        given: whether it is an argument that an `include` is given, which has a value and no default.
    """
    pairs = _FORMS.get(tag, ())
    if given:
        pairs = _FORMS["let"]
    if not pairs:
        return ""
    if yaml:
        return "{" + ", ".join(f"{name}: {value}" for name, value in pairs) + "}"
    return f"<{tag} " + " ".join(f'{name}="{value}"' for name, value in pairs) + "/>"


def about_attributes(tag: str, names: Sequence[str], allowed: Collection[str], yaml: bool) -> str:
    """Return which attributes an element hasn't, what to write instead of each, and which it has.

    Args:
        tag: the element's.
        names: those that it hasn't.
        allowed: those that are understood.
        yaml: whether the file is YAML.
    """
    told = [f"{name!r} is not supported{_about_attribute(tag, name, allowed, yaml)}" for name in names]
    return f"the attribute {', and '.join(told)} (supported: {listing(sorted(allowed))})"


def _about_attribute(tag: str, name: str, allowed: Collection[str], yaml: bool) -> str:
    for (of, names), inner in _IN_PLACE.items():
        if tag == of and name in names:
            return f"; that is {inner_form(inner, tag, yaml)}"
    if (tag, name) in _INSTEAD:
        return f"; {_INSTEAD[tag, name]}"
    meant = next((other for other in _ATTRIBUTES.get(name, ()) if other in allowed), None)
    return f"; write {meant!r}" if meant else nearest(name, allowed)


def inner_form(tag: str, inside: str, yaml: bool) -> str:
    """Return how an element in another one is written, as the end of a sentence."""
    said = form(tag, yaml, given=inside == "include")
    file = "; of a file: " + ("{from: FILE}" if yaml else '<param from="FILE"/>') if tag == "param" else ""
    return (f"a list: `{tag}: [{said}]`" if yaml else f"an element in <{inside}>: {said}") + file


def about_tag(tag: str, inside: str, allowed: Collection[str], yaml: bool) -> str:
    """Return what to write instead of an element that can't stand where it does.

    Args:
        tag: the element's.
        inside: that of the element around it; `launch` and `group` hold anything.
        allowed: the tags that can stand there.
        yaml: whether the file is YAML.
    """
    if tag in ("param", "parameter") and inside == "include":
        return f"; an argument of the file is given by {form('arg', yaml, given=True)}"
    if tag in ("arg", "argument") and inside == "node":
        return "; the arguments of its program are the attribute 'args'"
    could_be = _TAGS.get(tag, (tag,))
    meant = next((other for other in could_be if other in allowed), None)
    if meant is not None:
        return f"; write `{meant}`: {form(meant, True)}" if yaml else f"; write {form(meant, False) or f'<{meant}>'}"
    if could_be[0] in _OUTSIDE:
        return f"; it {_OUTSIDE[could_be[0]]}"
    return nearest(tag, allowed)


def given_as(tag: str, key: str) -> str:
    """Return how a key of YAML is given, as the end of a sentence, where a mapping or a list was given instead."""
    for (of, names), inner in _IN_PLACE.items():
        if tag == of and key in names:
            return f"; it is {inner_form(inner, tag, True)}"
    return "; it is one text" if key in ("args", "ros_args", "cmd", "launch-prefix") else ""
