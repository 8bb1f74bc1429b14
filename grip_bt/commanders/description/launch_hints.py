"""What a package's launch files tell of its robot, read and never run: which files, with which arguments.

ROS 1's XML, ROS 2's XML and ROS 2's Python (`moveit_configs_utils` and plain ones) are looked through alike. What only
a run knows, such as a condition, isn't decided: everything that is said anywhere is a hint, and whether the URDF and
the SRDF fit each other tells which were right.
"""

from __future__ import annotations

import ast
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .files import note
from .xml import parse_xml

_FILE = re.compile(r"[\w./$() -]*?([\w.-]+\.(?:urdf|srdf|xacro)(?:\.xacro)?)\b")
_GIVEN = re.compile(r"\b(\w+):=(?:'([^'$]*)'|\"([^\"$]*)\"|([^\s'\"$(){}]+))")
_ALIAS = re.compile(r"\b(\w+):=['\"]?\$\(arg (\w+)\)")
_FIND = re.compile(r"\$\(find(?:-pkg-share)? +([\w-]+)\)")
_PACKAGE_OF = ("FindPackageShare", "get_package_share_directory", "get_package_share_path")


@dataclass
class Hints:
    """What launch files say.

    Attributes:
        files: names of URDF, SRDF and xacro files, in order.
        packages: names of the packages that are looked up.
        given: argument -> values that are given to it somewhere, in order.
        defaults: argument -> its default.
        choices: argument -> values that it may have.
        aliases: argument -> the launch file's argument that it is given.
    """

    files: list[str] = field(default_factory=list)
    packages: list[str] = field(default_factory=list)
    given: dict[str, list[str]] = field(default_factory=dict)
    defaults: dict[str, str] = field(default_factory=dict)
    choices: dict[str, list[str]] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)

    def look_at(self, text: str) -> None:
        """Take files, packages and arguments out of a text."""
        self.files += _FILE.findall(text)
        self.packages += _FIND.findall(text)
        for name, *values in _GIVEN.findall(text):
            self.give(name, "".join(values))
        self.aliases.update(_ALIAS.findall(text))

    def give(self, name: str, value: str) -> None:
        """Remember a value of an argument."""
        values = self.given.setdefault(name, [])
        if value not in values:
            values.append(value)


def hints_of(folder: Path) -> Hints:
    """Return what the launch files of a package say; those that can't be read say nothing."""
    hints = Hints()
    launch = folder / "launch"
    for path in sorted(launch.rglob("*")) if launch.is_dir() else ():
        if not path.is_file() or path.stat().st_size > 2**20:
            continue
        note(path)
        text = path.read_text(encoding="utf-8", errors="replace")
        try:
            if path.suffix == ".py":
                _python(ast.parse(text), hints)
            elif path.suffix in (".launch", ".xml"):
                _xml(parse_xml(text, "launch", str(path)), hints)
        except (SyntaxError, ValueError, RecursionError, DocumentError):
            continue
    for name, other in hints.aliases.items():
        if name not in hints.given and (value := hints.defaults.get(other)):
            hints.give(name, value)
    return hints


def _xml(root: ET.Element, hints: Hints) -> None:
    for element in root.iter():
        name = element.get("name", "")
        if element.tag == "arg" and name:
            default, value = element.get("default"), element.get("value")
            if default is not None and "$(" not in default:
                hints.defaults[name] = hints.defaults.get(name) or default.strip("'\" ")
            if value is not None and "$(" not in value:
                hints.give(name, value.strip("'\" "))
        for text in element.attrib.values():
            hints.look_at(text)


def _python(tree: ast.Module, hints: Hints) -> None:
    for node in _in_order(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            hints.look_at(node.value)
        elif isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                if key is not None and (name := _word(key)) and (said := _word(value)) is not None:
                    hints.give(name, said)
        elif isinstance(node, ast.Call):
            _call(node, hints)


def _call(node: ast.Call, hints: Hints) -> None:
    function = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    arguments = {key.arg: key.value for key in node.keywords}
    first = node.args[0] if node.args else arguments.get("name") or arguments.get("package")
    name = None if first is None else _word(first)
    if function in _PACKAGE_OF and name:
        hints.packages.append(name)
    elif function == "MoveItConfigsBuilder":
        package = arguments.get("package_name")
        hints.packages += filter(None, [_word(package) if package else name and f"{name}_moveit_config"])
    elif function in ("DeclareLaunchArgument", "LaunchConfiguration") and name:
        default = arguments.get("default_value") or arguments.get("default")
        if default is not None and (said := _word(default)) is not None:
            hints.defaults.setdefault(name, said)
        choices = arguments.get("choices")
        if isinstance(choices, ast.List | ast.Tuple):
            hints.choices.setdefault(name, [said for each in choices.elts if (said := _word(each)) is not None])


def _in_order(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes as they are written."""
    yield tree
    for child in ast.iter_child_nodes(tree):
        yield from _in_order(child)


def _word(node: ast.expr) -> str | None:
    """Return a literal text, number or truth value as a text."""
    if not isinstance(node, ast.Constant) or not isinstance(node.value, str | bool | int | float):
        return None
    return str(node.value).lower() if isinstance(node.value, bool) else str(node.value)


def names(words: Iterable[str]) -> list[str]:
    """Return names once each, in order."""
    return list(dict.fromkeys(words))
