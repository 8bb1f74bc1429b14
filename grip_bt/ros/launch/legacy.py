"""Launch files of ROS 1: known by what only they say, and told line by line what ROS 2 says instead."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from .element import Element, LegacyLaunchFileError

_TAGS = {
    "rosparam": '<param from="FILE"/> inside the <node> whose parameters they are; there is no parameter server',
    "machine": "nothing: start a launch file on each machine",
    "test": "launch_testing, in Python",
    "env-loader": "nothing: the environment is inherited",
}
_ATTRIBUTES = {
    ("node", "type"): 'exec="..."',
    ("node", "ns"): 'namespace="..."',
    ("node", "required"): 'on_exit="shutdown"',
    ("node", "clear_params"): "nothing: parameters live in their node",
    ("node", "machine"): "nothing: start a launch file on each machine",
    ("group", "ns"): '<push_ros_namespace namespace="..."/> as the first element of the group',
    ("include", "ns"): 'a <group> with <push_ros_namespace namespace="..."/> around the include',
    ("include", "clear_params"): "nothing: parameters live in their node",
    ("include", "pass_all_args"): "nothing: includes see the arguments of the file that includes them",
    ("param", "command"): "value=\"$(command '...')\", or the output as an argument",
    ("param", "textfile"): "value=\"$(command 'cat FILE')\", or the text as an argument",
    ("param", "binfile"): "nothing: parameters are no files",
}
_SUBSTITUTIONS = (
    (re.compile(r"\$\(find [^)]*\)"), "$(find-pkg-share PACKAGE)"),
    (re.compile(r"\$\(arg [^)]*\)"), "$(var NAME)"),
    (re.compile(r"\$\(optenv [^)]*\)"), "$(env NAME DEFAULT)"),
    (re.compile(r"\$\(eval [^)]*\)"), "conditions with `equals`, `not`, `and`, `or`"),
)


def check_not_legacy(root: Element, path: Path) -> None:
    """Refuse a launch file of ROS 1.

    Raises:
        LegacyLaunchFileError: it is one; with every line that has to change.
    """
    changes = list(_changes(root))
    if any(certain for certain, *_ in changes):
        raise LegacyLaunchFileError(str(path), [(line, old, new) for _, line, old, new in changes])


def _changes(element: Element) -> Iterator[tuple[bool, int, str, str]]:
    """Yield what has to change: whether only ROS 1 has it, its line, what is written and what to write."""
    for child in element.children:
        if child.tag in _TAGS:
            yield True, child.line, f"<{child.tag}>", _TAGS[child.tag]
        for name, text in child.attributes.items():
            if (child.tag, name) in _ATTRIBUTES:
                yield True, child.line, f"<{child.tag} {name}={text!r}>", _ATTRIBUTES[child.tag, name]
            for pattern, new in _SUBSTITUTIONS:
                for found in pattern.findall(text):
                    yield not found.startswith("$(eval"), child.line, found, new
        if child.tag == "param" and element.tag in ("launch", "group"):
            same = "the same inside the <node> whose parameter it is"
            yield False, child.line, f"<param> in <{element.tag}>", same
        if child.tag == "arg" and element.tag != "include" and "value" in child.attributes:
            old = f"<arg name={child.attributes.get('name')!r} value=...>"
            yield False, child.line, old, "<let name=... value=.../>"
        yield from _changes(child)
