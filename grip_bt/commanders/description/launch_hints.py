"""What a package's launch files tell of its robot, read and never run: which files, with which arguments.

ROS 1's XML, ROS 2's XML and ROS 2's Python (`moveit_configs_utils` and plain ones) are looked through alike, as texts.
What only a run knows, such as a condition, isn't decided: everything that is said anywhere is a hint, and whether the
URDF and the SRDF fit each other tells which were right.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from .files import note

LARGEST = 2**20
_COMMENT = re.compile(r"<!--.*?-->|^\s*#[^\n]*$", re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"([\w.-]+\.(?:urdf|srdf|xacro)(?:\.xacro)?)\b")
_LITERAL = r"""(?:['"]([^'"]*)['"]|(True|False|[\d.]+))"""
"""Of Python; a name isn't a value."""
_PACKAGES = re.compile(
    r"""\$\(find(?:-pkg-share)?\s+([\w-]+)\)|MoveItConfigsBuilder\([^)]*package_name=['"]([\w-]+)['"]"""
    r"""|(?:FindPackageShare|get_package_share_\w+)\(\s*(?:package=)?['"]([\w-]+)['"]"""
)
_GIVEN = (
    re.compile(r"""\b(\w+):=['"]?([^'"\s,(){}$<>]+)['"]?(?=[\s'"/>]|$)"""),
    re.compile(rf"""['"](\w+)['"]\s*:\s*{_LITERAL}\s*[,}}]"""),
    re.compile(r"""<arg\s+name=['"](\w+)['"]\s+value=['"]'?([^'"$]*)'?['"]"""),
)
_DEFAULTS = (
    re.compile(
        r"""(?:DeclareLaunchArgument|LaunchConfiguration)\(\s*(?:name=)?['"](\w+)['"]\s*,"""
        rf"""\s*default(?:_value)?={_LITERAL}\s*[,)]"""
    ),
    re.compile(r"""<arg\s+name=['"](\w+)['"]\s+default=['"]'?([^'"$]*)'?['"]"""),
)
_ALIAS = re.compile(r"\b(\w+):=['\"]?\$\(arg (\w+)\)")
_CHOICES = re.compile(
    r"""DeclareLaunchArgument\(\s*(?:name=)?['"](\w+)['"](?:(?!DeclareLaunchArgument).)*?choices=\[([^\]]*)\]""",
    re.DOTALL,
)


@dataclass
class Hints:
    """What launch files say.

    Attributes:
        files: names of URDF, SRDF and xacro files, in order.
        packages: names of the packages that are looked up.
        given: argument -> values that are given to it somewhere, in order.
        defaults: argument -> its default.
        choices: argument -> values that it may have.
    """

    files: list[str] = field(default_factory=list)
    packages: list[str] = field(default_factory=list)
    given: dict[str, list[str]] = field(default_factory=dict)
    defaults: dict[str, str] = field(default_factory=dict)
    choices: dict[str, list[str]] = field(default_factory=dict)


def hints_of(folder: Path) -> Hints:
    """Return what the launch files of a package say."""
    hints, texts = Hints(), []
    for path in sorted((folder / "launch").rglob("*")):
        if path.suffix in (".py", ".launch", ".xml") and path.is_file() and path.stat().st_size <= LARGEST:
            note(path)
            texts.append(_COMMENT.sub("", path.read_text(encoding="utf-8", errors="replace")))
    text = "\n".join(texts)
    hints.files = _FILE.findall(text)
    hints.packages = ["".join(found) for found in _PACKAGES.findall(text)]
    for name, value in _found(_DEFAULTS, text):
        hints.defaults[name] = hints.defaults.get(name) or value
    for name, value in _found(_GIVEN, text):
        if value not in (values := hints.given.setdefault(name, [])):
            values.append(value)
    for name, other in _ALIAS.findall(text):
        if not any(hints.given.get(name, ())) and hints.defaults.get(other):
            hints.given[name] = [hints.defaults[other]]
    for name, words in _CHOICES.findall(text):
        hints.choices.setdefault(name, re.findall(r"""['"]([^'"]*)['"]""", words))
    return hints


def _found(patterns: Iterable[re.Pattern[str]], text: str) -> Iterator[tuple[str, str]]:
    for name, *words in (found for pattern in patterns for found in pattern.findall(text)):
        value = "".join(words).strip()
        yield name, value.lower() if value in ("True", "False") else value
