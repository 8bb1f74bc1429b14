"""Interface files read by rosidl's own parser, with the line of what is wrong, which that parser doesn't tell."""

from __future__ import annotations

import contextlib
import io
import keyword
import re
from collections.abc import Sequence, Set
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any, cast

from grip_bt.base.errors import DocumentError, MissingPartError, listing, nearest
from grip_bt.ros.interfaces.packages import (
    KINDS,
    Package,
    find_packages,
    package_like,
    read_package,
    search_path,
    share_folder,
)
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec, Kind

_SECTIONS = {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}
_SEPARATOR = "---"


def read_interface(source: str | Path) -> InterfaceSpec:
    """Read an interface from its file, or by its type's name from the installed packages.

    Args:
        source: a .msg, .srv or .action file in a package's `<kind>/` folder, or a name such as `std_srvs/srv/Trigger`.

    Raises:
        DocumentError: the file can't be read or is wrong (with its line), or no installed package has the type.
    """
    path = Path(source)
    if path.suffix[1:] not in KINDS:
        path = _installed_file(str(source))
    folder = path.resolve().parent.parent
    package = read_package(folder).name if (folder / "package.xml").is_file() else folder.name
    return parse_interface(read_text(path), package, path.suffix[1:], path.stem, str(path))


def read_text(path: Path) -> str:
    """Return the text of an interface file.

    Raises:
        DocumentError: it can't be read, or isn't UTF-8 text as ROS wants it.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DocumentError(f"can't be read: {error.strerror}", str(path)) from None
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise DocumentError(
            f"isn't UTF-8 text: byte 0x{data[error.start]:02x}; save it as UTF-8", str(path), line
        ) from None
    if text.startswith("\ufeff"):
        raise DocumentError(
            "begins with a byte order mark, which ROS can't read: save it as UTF-8 without", str(path), 1
        )
    return text


def parse_interface(text: str, package: str, kind: str, name: str, source: str = "") -> InterfaceSpec:
    """Make a specification from the text of an interface file.

    Raises:
        DocumentError: a line can't be understood, or the number of `---` lines is wrong.
    """
    parser = _parser()
    source = source or f"{name}.{kind}"
    if not parser.is_valid_message_name(name):
        raise DocumentError(f"an interface is named like CamelCase, without underscores, not {name!r}", source)
    sections = _split(text, kind, source)
    specs = [
        _parse_section(package, name + suffix, lines, first, source)
        for suffix, (first, lines) in zip(_SECTIONS[kind], sections, strict=True)
    ]
    request, response, feedback = ([tuple(map(_field, spec.fields)) for spec in specs] + [(), ()])[:3]
    doc = " ".join(line.strip() for line in specs[0].annotations.get("comment", []) if line.strip())
    known = cast(Kind, kind)
    return InterfaceSpec(package, known, name, request, response, feedback, doc=doc, source=source)


def _installed_file(type_name: str) -> Path:
    parts = type_name.split("/")
    if len(parts) != 3 or parts[1] not in KINDS:
        meant = _meant(parts)
        such = f"; write {meant!r}" if meant else " such as 'std_srvs/srv/Trigger'"
        raise DocumentError(f"is neither a .msg, .srv or .action file nor a type{such}", type_name)
    package, kind, name = parts
    share = share_folder(package, search_path())
    if share is None:
        hint = package_like(package, search_path())
        raise DocumentError(f"no package {package!r} is installed or built here{hint and '; ' + hint}", type_name)
    file = share / kind / f"{name}.{kind}"
    if not file.is_file():
        known = sorted(f.stem for f in (share / kind).glob(f"*.{kind}"))
        has = ", ".join(known[:20]) or "none"
        raise DocumentError(f"{package} has no {kind} {name!r}{nearest(name, known)} (it has: {has})", type_name)
    return file


def _meant(parts: Sequence[str]) -> str:
    """Return the whole name of an installed type that was written without its kind, or with another word for it."""
    share = share_folder(parts[0], search_path())
    kinds = [kind for kind in KINDS if share is not None and (share / kind / f"{parts[-1]}.{kind}").is_file()]
    return f"{parts[0]}/{kinds[0]}/{parts[-1]}" if kinds else ""


def _parser() -> Any:
    try:
        from rosidl_adapter import parser
    except ImportError:
        raise MissingPartError("rosidl_adapter (ROS 2's interface parser)", "pip install 'grip-bt[ros]'") from None
    return parser


def _split(text: str, kind: str, source: str) -> list[tuple[int, list[str]]]:
    sections: list[tuple[int, list[str]]] = [(1, [])]
    for number, line in enumerate(text.splitlines(), 1):
        if line == _SEPARATOR:
            sections.append((number + 1, []))
        else:
            sections[-1][1].append(line)
    wanted = len(_SECTIONS[kind])
    if len(sections) != wanted:
        what = {"msg": "no line", "srv": "one line", "action": "two lines"}[kind]
        line_no = sections[wanted][0] - 1 if len(sections) > wanted else max(1, len(text.splitlines()))
        raise DocumentError(
            f"a .{kind} file has {what} with just {_SEPARATOR!r}, this one has {len(sections) - 1}", source, line_no
        )
    return sections


def _parse_section(package: str, name: str, lines: list[str], first: int, source: str) -> Any:
    parse = _parser().parse_message_string
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            return parse(package, name, "\n".join(lines))
    except Exception as error:  # noqa: BLE001 - the parser raises its own and builtin errors alike
        whole = error
    for count in range(1, len(lines) + 1):
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                parse(package, name, "\n".join(lines[:count]))
        except Exception as error:  # noqa: BLE001
            line = lines[count - 1].strip()
            raise DocumentError(f"{_reason(error, line)}, in {line!r}", source, first + count - 1) from None
    raise DocumentError(str(whole), source, first)


def _reason(error: Exception, line: str) -> str:
    """Return what is wrong with a line, in words of the file rather than of the parser."""
    kind, told = type(error).__name__, str(error)
    quoted = next(iter(re.findall(r"'([^']*)'", told)), "")
    if kind == "InvalidFieldDefinition":
        return "a field is written as 'type name', a constant as 'type NAME=value'"
    if kind == "InvalidResourceName":
        return f"{line.split()[0]!r} isn't a type: a primitive, or Package/Message"
    if kind == "NameError" and "constant name" in told:
        return f"{quoted!r} can't name a constant: capitals, digits and single underscores; a default has no '='"
    if kind == "NameError":
        return f"{quoted!r} can't name a field: lower case letters, digits and single underscores, a letter first"
    if "duplicate names" in told:
        what = "constants" if "constants" in told else "fields"
        return f"two {what} are named {told.rpartition(': ')[2]!r}"
    if "size of array" in told:
        return "the size of an array is a whole number above 0: [3], at most three: [<=3], any number: []"
    return told or kind


def _field(field: Any) -> FieldSpec:
    type_ = field.type
    name = f"{type_.pkg_name}/msg/{type_.type}" if type_.pkg_name else type_.type
    doc = " ".join(line.strip() for line in field.annotations.get("comment", []) if line.strip())
    if unit := field.annotations.get("unit"):
        doc = f"{doc} [{unit}]".strip()
    return FieldSpec(field.name, name, type_.is_array, type_.array_size, type_.is_upper_bound, doc)


def interface_file(folder: Path, type_name: str) -> Path | None:
    """Return the file that defines a type such as `my_interfaces/srv/Grasp`; None when its package isn't in `folder`.

    Raises:
        DocumentError: a package there is broken, or is the type's and doesn't define it.
    """
    if not folder.is_dir():
        return None
    package_name, kind, name = type_name.split("/")
    for package in find_packages(folder):
        if package.name == package_name:
            for file in package.files:
                if file.as_posix() == f"{kind}/{name}.{kind}":
                    return package.folder / file
            known = [f"{package_name}/{file.parent}/{file.stem}" for file in package.files]
            hint = nearest(name, [file.stem for file in package.files])
            raise DocumentError(f"defines no {type_name}{hint} (it defines: {listing(known)})", str(package.folder))
    return None


def fields_within(folder: Path | None, message: str) -> tuple[FieldSpec, ...] | None:
    """Return the fields of a message that a folder of packages defines, or that is installed; None for any other.

    Args:
        folder: the interface packages; None for installed ones only.
        message: its type, such as `geometry_msgs/msg/Pose`.
    """
    if message.count("/") != 2 or message.split("/")[1] not in KINDS:
        return None
    try:
        return read_interface((folder and interface_file(folder, message)) or message).request
    except DocumentError:
        return None  # a build says what is wrong with it


_C = """auto break case char const continue default do double else enum extern float for goto if inline int long
register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while"""
_CPP = """alignas alignof and and_eq asm bitand bitor bool catch char16_t char32_t class compl constexpr const_cast
decltype delete dynamic_cast explicit export false friend mutable namespace new noexcept not not_eq nullptr operator or
or_eq private protected public reinterpret_cast static_assert static_cast template this thread_local throw true try
typeid typename using virtual wchar_t xor xor_eq"""
_RESERVED = {
    word: language
    for language, words in (("Python", keyword.kwlist), ("C++", _CPP.split()), ("C", _C.split()))
    for word in words
}
_ONLY_ROS_1 = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration"}


def check_package(package: Package, prefixes: Sequence[Path], beside: Set[str] = frozenset()) -> None:
    """Read every interface of a package and check that it can be built.

    Args:
        beside: names of the packages that are built with it.

    Raises:
        DocumentError: a file is wrong; it says which, where and why.
    """
    own = {f.stem for f in package.files if f.suffix == ".msg"}
    specs = []
    for file in package.files:
        path = package.folder / file
        specs.append(parse_interface(read_text(path), package.name, file.suffix[1:], file.stem, str(path)))
        spec = specs[-1]
        for field in (*spec.request, *spec.response, *spec.feedback):
            if language := _RESERVED.get(field.name):
                told = f"it is a keyword of {language}; rename it, for example to '{field.name}_value'"
                raise _wrong(spec, field, told)
            _check_type(spec, field, own, prefixes, beside - package.depends)
    _check_circles([spec for spec in specs if spec.kind == "msg"])


def _check_type(
    spec: InterfaceSpec, field: FieldSpec, own: set[str], prefixes: Sequence[Path], unasked: Set[str]
) -> None:
    """Check that the message type of a field exists.

    Args:
        own: names of the messages of its own package.
        unasked: packages of the same folder for which package.xml doesn't ask.

    Raises:
        DocumentError: a type or its package isn't there, with the line that asks for it.
    """
    if field.type in _ONLY_ROS_1:
        raise _wrong(spec, field, f"{field.type!r} is of ROS 1; ROS 2 has {_ONLY_ROS_1[field.type]}")
    if "/" not in field.type:
        return
    package, _, message = field.type.partition("/msg/")
    if package == spec.package:
        known, where = own, "this package"
    elif package in unasked:
        raise _wrong(spec, field, f"package.xml has to ask for {package!r}: <depend>{package}</depend>")
    else:
        share = share_folder(package, prefixes)
        if share is None:
            raise _wrong(spec, field, f"there is no package {package!r} here (installed, or in the same folder)")
        known, where = {f.stem for f in (share / "msg").glob("*.idl")}, package
    if message not in known:
        raise _wrong(spec, field, f"{where} has no message {message!r}{nearest(message, known)}")


def _check_circles(messages: Sequence[InterfaceSpec]) -> None:
    """Check that no message holds itself, directly or not: ROS has no such types."""
    by_type = {spec.type_name: spec for spec in messages}
    graph = {name: [f.type for f in spec.request if f.type in by_type] for name, spec in by_type.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        circle = list(reversed(error.args[1]))
        spec = by_type[circle[0]]
        field = next(f for f in spec.request if f.type == circle[1])
        told = " -> ".join(name.replace("/msg/", "/") for name in circle)
        raise _wrong(spec, field, f"a message can't hold itself: {told}") from None


def _wrong(spec: InterfaceSpec, field: FieldSpec, told: str) -> DocumentError:
    return DocumentError(f"field {field.name!r}: {told}", spec.source, _line_of(field, spec.source))


def _line_of(field: FieldSpec, source: str) -> int | None:
    for number, line in enumerate(read_text(Path(source)).splitlines(), 1):
        words = line.partition("#")[0].split()
        if len(words) >= 2 and words[1] == field.name:
            return number
    return None
