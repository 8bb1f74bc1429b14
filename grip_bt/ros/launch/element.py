"""A launch file as elements: the one shape of its XML and its YAML form; what can be wrong with it, such as ROS 1."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.xml import XmlElement, parse_xml
from grip_bt.base.yaml.tree import YamlList, YamlMapping, YamlScalar, YamlValue, parse, read_file, to_data

from ..process import text_of

DEEPEST = 50
"""Elements in elements; what launch files need is a handful."""
_MANY = {"param", "remap", "env", "arg", "let", "choice", "composable_node", "extra_arg"}
"""Keys of YAML whose list holds sub-elements."""


_LISTS = ("value", "default")
"""Keys of YAML that may hold a list of values."""
_SUCH = "such as `- node: {pkg: P, exec: X}`"


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
    if path.suffix == ".py":
        said = "is a program for `ros2 launch`, which isn't here; source a ROS that has it"
        other = (
            f"(source /opt/ros/jazzy/setup.bash), or say the same in XML ({path.name.removesuffix('.py')}.xml) or YAML"
        )
        reason = f"a launch file in Python {said} {other}" if path.is_file() else "there is no such file"
        raise LaunchError(str(path), None, reason)
    try:
        text = read_file(path)
        if path.suffix in (".yaml", ".yml"):
            return _from_yaml(text, str(path))
        check_not_legacy(text, path)
        return _from_xml(text, str(path))
    except DocumentError as error:
        raise LaunchError(str(path), error.line, error.message) from None


def _from_xml(text: str, source: str) -> Element:
    def element(found: XmlElement) -> Element:
        return Element(found.tag, found.attrib, [element(each) for each in found], found.line or 0)  # type: ignore[arg-type]

    top = element(parse_xml(text, source, DEEPEST))
    if top.tag != "launch":
        raise LaunchError(source, top.line, f"a launch file begins with <launch>, not with <{top.tag}>")
    return top


def _from_yaml(text: str, source: str) -> Element:
    tree = parse(text, source)
    if not isinstance(tree, YamlMapping) or list(tree.entries) != ["launch"]:
        raise LaunchError(source, 1, f"a launch file in YAML holds the one key `launch`, with a list, {_SUCH}")
    return _element("launch", tree.entries["launch"].value, tree.entries["launch"].line, source)


def _listed(value: YamlValue, source: str) -> Iterator[Element]:
    if not isinstance(value, YamlList):
        raise LaunchError(source, value.line, f"a list of `- tag: {{...}}` is expected, {_SUCH}")
    for item in value.entries:
        inner = item.value
        if not isinstance(inner, YamlMapping) or len(inner.entries) != 1:
            raise LaunchError(source, item.line, f"each item is one `tag: {{...}}`, {_SUCH}")
        ((tag, entry),) = inner.entries.items()
        yield _element(tag, entry.value, entry.line, source)


def _element(tag: str, value: YamlValue, line: int, source: str) -> Element:
    """Return an element; a key of its mapping is an attribute, or sub-elements where it holds a list."""
    element = Element(tag, {}, line=line)
    if tag == "launch" or (tag == "group" and isinstance(value, YamlList)):  # a list of what is in it
        element.children = list(_listed(value, source))
        return element
    if not isinstance(value, YamlMapping):
        raise LaunchError(source, line, f"`{tag}` holds a mapping without dashes, {_SUCH}")
    for key, entry in value.entries.items():
        inner = entry.value
        items = [item.value for item in inner.entries] if isinstance(inner, YamlList) else []
        if isinstance(inner, YamlScalar):
            element.attributes[key] = text_of(inner.value)
        elif isinstance(inner, YamlList) and key == "children":
            element.children += _listed(inner, source)
        elif isinstance(inner, YamlList) and key in _MANY:
            element.children += [_element(key, item.value, item.line, source) for item in inner.entries]
        elif items and key in _LISTS and all(isinstance(item, YamlScalar) for item in items):
            element.attributes[key] = "[" + ", ".join(text_of(word) for word in to_data(inner)) + "]"
        else:
            wanted = "a list of mappings" if key in _MANY else "one text"
            raise LaunchError(source, entry.line, f"`{tag}`: `{key}` is {wanted}")
    return element


class LaunchError(GripError):
    """A launch file can't be run as it is."""

    def __init__(self, source: str, line: int | None, reason: str):
        self.source, self.line, self.reason = source, line, reason
        super().__init__(f"{source}:{line}: {reason}" if line else f"{source}: {reason}")


_OF_ROS_1 = re.compile(
    r"\$\((?:find|arg|optenv) |<rosparam|<node[^>]* type=|<(?:group|include|node)[^>]* ns=|<param[^>]* command="
)


def check_not_legacy(text: str, path: Path) -> None:
    """Refuse the text of a launch file of ROS 1. Raises LaunchError: it is one; with the first line that shows that."""
    if found := _OF_ROS_1.search(text):
        line, change = text.count("\n", 0, found.start()) + 1, "docs/launching.md lists what to change"
        raise LaunchError(str(path), line, f"this is a ROS 1 launch file: {found[0].split()[-1]!r}; {change}")
