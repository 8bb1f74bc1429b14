"""What a package's launch and xacro files tell of its robot, read and never run: which files, with which arguments.

Launch files of ROS 1 and ROS 2 are looked through alike, as texts. What only a run knows, such as a condition, isn't
decided: whatever is said is a hint, and whether the URDF and the SRDF fit each other tells which were right.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .file_cache import note
from .packages import Packages
from .xml import read_xml

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
    files = sorted((folder / "launch").rglob("*"))
    return hints_in("\n".join(read_launch(p) for p in files if p.suffix in (".py", ".launch", ".xml")))


def read_launch(path: Path) -> str:
    """Return a launch file's text without comments; empty of what is no file, or too large for one."""
    if not path.is_file() or path.stat().st_size > LARGEST:
        return ""
    note(path)
    return _COMMENT.sub("", path.read_text(encoding="utf-8", errors="replace"))


def hints_in(text: str) -> Hints:
    """Return what the texts of launch files say."""
    hints = Hints(_FILE.findall(text), ["".join(found) for found in _PACKAGES.findall(text)])
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


@dataclass(frozen=True)
class Declared:
    """What a xacro file says of itself before it is expanded.

    Attributes:
        arguments: those that it declares or uses, in order: name -> default, or None.
        choices: argument -> values for which a file is there that `$(find NAME)/.../$(arg ARGUMENT)...` names.
        whole: whether it holds a robot; else only macros for others.
    """

    arguments: Mapping[str, str | None]
    choices: Mapping[str, list[str]]
    whole: bool = True


_BY_ARGUMENT = re.compile(r"\$\(find ([\w-]+)\)((?:/[\w.-]+)*)/([\w.-]*)\$\(arg (\w+)\)([\w./-]*)")
_USED, _XML_COMMENT = re.compile(r"\$\(arg (\w+)\)"), re.compile(r"<!--.*?-->", re.DOTALL)
_ASIDE = ("xacro:include", "xacro:arg", "xacro:property", "xacro:macro")


def declared(path: Path, packages: Packages) -> Declared:
    """Return it; nothing of a file that can't be read."""
    try:
        root = read_xml(path, "robot")
        text = path.read_text(encoding="utf-8", errors="replace")
    except DocumentError:
        return Declared({}, {})
    arguments: dict[str, str | None] = {}
    for element in root.iter("xacro:arg"):
        if name := element.get("name"):
            arguments.setdefault(name, element.get("default"))
    for name in _USED.findall(_XML_COMMENT.sub("", text)):
        arguments.setdefault(name, None)
    choices: dict[str, list[str]] = {}
    for package, folders, begin, name, end in _BY_ARGUMENT.findall(text):
        home = packages.known(package)
        found = sorted((home / folders.strip("/")).glob(f"{begin}*{end}")) if home is not None else []
        place = -len(Path(end).parts) if end.startswith("/") else -1  # of what the star stands for, from the right
        rest = "" if end.startswith("/") else end
        values = [path.parts[place].removeprefix(begin).removesuffix(rest) for path in found]
        if values:
            choices.setdefault(name, values)
    return Declared(arguments, choices, any(element.tag not in _ASIDE for element in root))
