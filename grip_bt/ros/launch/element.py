"""A launch file as elements: the one shape of its XML and its YAML form; what can be wrong with it, such as ROS 1."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.yaml.tree import YamlList, YamlMapping, YamlScalar, YamlValue, parse, read_file, to_data

from .hints import form, given_as

DEEPEST = 50
"""Elements in elements; what launch files need is a handful."""
_MANY = {"param", "remap", "env", "arg", "let", "choice", "composable_node", "extra_arg"}
"""Keys of YAML whose list holds sub-elements."""


_ON_GROUPS = ("launch", "group")
"""Tags that hold a list of elements in YAML."""
_LISTS = ("value", "default")
"""Keys of YAML that may hold a list of values."""
_BROKEN = {
    expat.errors.codes[expat.errors.XML_ERROR_INVALID_TOKEN]: (
        '; each attribute is NAME="VALUE" in quotation marks, and in it & is written &amp;, < is written &lt;'
    ),
    expat.errors.codes[expat.errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT]: "; all of it stands in one <launch>",
    expat.errors.codes[expat.errors.XML_ERROR_NO_ELEMENTS]: "; it begins with <launch> and ends with </launch>",
}


@dataclass
class Element:
    """One element: its tag, its attributes as text, what is in it, and its line."""

    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    line: int = 0

    def of(self, tag: str) -> Iterator[Element]:
        """Yield the children of one tag."""
        return (child for child in self.children if child.tag == tag)


def read_elements(path: Path) -> Element:
    """Return the root `launch` element of an XML or a YAML file.

    Raises:
        LaunchError: it can't be read or isn't well-formed.
    """
    try:
        text = read_file(path)
        if path.suffix in (".yaml", ".yml"):
            return _from_yaml(text, str(path))
    except DocumentError as error:
        raise LaunchError(str(path), error.line, error.message) from None
    return _from_xml(text, str(path))


def _from_xml(text: str, source: str) -> Element:
    """Read XML; entities are refused, so that nothing expands."""
    parser = expat.ParserCreate()
    root = Element("", {})
    stack = [root]

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEEPEST:
            raise LaunchError(source, parser.CurrentLineNumber, f"elements are nested more than {DEEPEST} deep")
        element = Element(tag, attributes, line=parser.CurrentLineNumber)
        stack[-1].children.append(element)
        stack.append(element)

    def refuse(*_: object) -> None:
        raise LaunchError(source, parser.CurrentLineNumber, "a launch file declares no entities")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: stack.pop()
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        reason = f"isn't well-formed XML: {expat.errors.messages[error.code]}{_BROKEN.get(error.code, '')}"
        raise LaunchError(source, error.lineno, reason) from None
    (top,) = root.children
    if top.tag != "launch":
        raise LaunchError(source, top.line, f"a launch file begins with <launch>, not with <{top.tag}>")
    return top


def _from_yaml(text: str, source: str) -> Element:
    tree = parse(text, source)
    if not isinstance(tree, YamlMapping) or list(tree.entries) != ["launch"]:
        raise LaunchError(
            source,
            1,
            "a launch file in YAML holds the one key `launch`, with a list, such as `- node: {pkg: P, exec: X}`",
        )
    root = Element("launch", {}, line=tree.entries["launch"].line)
    root.children = list(_listed(tree.entries["launch"].value, source))
    return root


def _listed(value: YamlValue, source: str) -> Iterator[Element]:
    if not isinstance(value, YamlList):
        raise LaunchError(
            source, value.line, "a list of `- tag: {...}` is expected, such as `- node: {pkg: P, exec: X}`"
        )
    for item in value.entries:
        inner = item.value
        if not isinstance(inner, YamlMapping) or len(inner.entries) != 1:
            reason = "each item is one `tag: {...}`, such as `- node: {pkg: P, exec: X}`"
            raise LaunchError(source, item.line, f"{reason}; what belongs to it is indented further")
        ((tag, entry),) = inner.entries.items()
        yield _tagged(tag, entry.value, entry.line, source)


def _tagged(tag: str, value: YamlValue, line: int, source: str) -> Element:
    element = Element(tag, {}, line=line)
    if isinstance(value, YamlList) and tag in _ON_GROUPS:  # a group is a list of what is in it
        element.children = list(_listed(value, source))
    elif isinstance(value, YamlMapping):
        for key, entry in value.entries.items():
            _add(element, key, entry.value, entry.line, source)
    else:
        how = form(tag, yaml=True)
        without = " without dashes" if isinstance(value, YamlList) else ""
        raise LaunchError(source, line, f"`{tag}` holds a mapping{without}{f', such as {how}' if how else ''}")
    return element


def _add(element: Element, key: str, value: YamlValue, line: int, source: str) -> None:
    """Add one key of a mapping: an attribute, or sub-elements where it holds a list."""
    if isinstance(value, YamlScalar):
        element.attributes[key] = text_of(value.value)
    elif isinstance(value, YamlList) and key == "children":
        element.children += _listed(value, source)
    elif isinstance(value, YamlList) and key in _MANY:
        for item in value.entries:
            element.children.append(_tagged(key, item.value, item.line, source))
    elif isinstance(value, YamlList) and key in _LISTS and all(isinstance(i.value, YamlScalar) for i in value.entries):
        element.attributes[key] = "[" + ", ".join(text_of(word) for word in to_data(value)) + "]"
    else:
        raise LaunchError(
            source, line, f"`{element.tag}`: `{key}` can't be given like this{given_as(element.tag, key)}"
        )


def text_of(value: object) -> str:
    """Return a scalar of YAML as a launch file's text."""
    return "true" if value is True else "false" if value is False else "" if value is None else str(value)


class LaunchError(GripError):
    """A launch file can't be run as it is.

    Attributes:
        source: the file.
        line: 1-based line, or None.
        reason: what is wrong, and what to do.
    """

    def __init__(self, source: str, line: int | None, reason: str):
        self.source, self.line, self.reason = source, line, reason
        super().__init__(f"{source}:{line}: {reason}" if line else f"{source}: {reason}")


class LegacyLaunchFileError(LaunchError):
    """A launch file is one of ROS 1; `changes` holds (line, what it says, what ROS 2 says)."""

    def __init__(self, source: str, changes: list[tuple[int, str, str]]):
        self.changes = changes
        listed = "".join(f"\n  line {line}: {old}: {new}" for line, old, new in changes)
        super().__init__(
            source, None, f"this is a ROS 1 launch file; to make it one of ROS 2 (.launch.xml), change:{listed}"
        )


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
