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
_TAGS = {
    **dict.fromkeys(("parameter", "parameters", "params"), ("param", "set_parameter")),
    **dict.fromkeys(("remapping", "remappings", "remaps"), ("remap", "set_remap")),
    **dict.fromkeys(("argument", "arguments", "args", "declare_argument"), ("arg",)),
    **dict.fromkeys(("exec", "process", "execute_process", "program", "command"), ("executable",)),
    **dict.fromkeys(("environment", "additional_env", "setenv"), ("env", "set_env")),
    **dict.fromkeys(("namespace", "push_namespace", "ns"), ("push_ros_namespace",)),
    "choices": ("choice",),
    "Node": ("node",),
}
"""A tag that is written -> those that may be meant; the first that can stand there is."""
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


def form(tag: str, yaml: bool, given: bool = False) -> str:
    """Return how an element is written, or an empty string where nobody knows.

    Args:
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


def about_attributes(
    tag: str, names: Sequence[str], allowed: Collection[str], inner: Collection[str], yaml: bool
) -> str:
    """Return which attributes an element hasn't, what to write instead of each, and which it has.

    Args:
        allowed: those that are understood.
        inner: tags of the elements that can stand in it.
    """

    def instead(name: str) -> str:
        element = next((other for other in _TAGS.get(name, (name,)) if other in inner), None)
        if element is not None:
            said = form(element, yaml, given=tag == "include")
            return f"; that is a list: `{element}: [{said}]`" if yaml else f"; that is an element in <{tag}>: {said}"
        meant = next((other for other in _ATTRIBUTES.get(name, ()) if other in allowed), None)
        return f"; write {meant!r}" if meant else nearest(name, allowed)

    told = [f"{name!r} is not supported{instead(name)}" for name in names]
    return f"the attribute {', and '.join(told)} (supported: {listing(sorted(allowed))})"


def about_tag(tag: str, allowed: Collection[str], outside: Sequence[str], yaml: bool) -> str:
    """Return what to write instead of an element that can't stand where it does.

    Args:
        allowed: the tags that can stand there.
        outside: tags of the elements in which it can stand.
    """
    meant = next((other for other in _TAGS.get(tag, (tag,)) if other in allowed), None)
    if meant is not None:
        return f"; write `{meant}`: {form(meant, True)}" if yaml else f"; write {form(meant, False) or f'<{meant}>'}"
    return f"; it stands in {' or '.join(f'<{tag}>' for tag in outside)}" if outside else nearest(tag, allowed)
