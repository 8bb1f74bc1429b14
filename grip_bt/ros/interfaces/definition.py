"""Interface files read by rosidl's own parser, with the line of what is wrong, which that parser doesn't tell."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from grip_bt.base.errors import DocumentError, MissingPartError, listing, nearest
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec, Kind

from .ament import package_like, search_path, share_folder
from .package import KINDS, find_packages, read_package

_SECTIONS = {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}
_SEPARATOR = "---"


def read_interface(source: str | Path, prefixes: Sequence[Path] = ()) -> InterfaceSpec:
    """Read an interface from its file, or by its type's name from the installed packages.

    Args:
        source: a .msg, .srv or .action file in a package's `<kind>/` folder, or a name such as `std_srvs/srv/Trigger`.
        prefixes: overlays in which a named type is looked for first.

    Raises:
        DocumentError: the file can't be read or is wrong (with its line), or no installed package has the type.
    """
    path = Path(source)
    if path.suffix[1:] not in KINDS:
        path = _installed_file(str(source), prefixes)
    package = _package_of(path.resolve())
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


def _installed_file(type_name: str, prefixes: Sequence[Path]) -> Path:
    parts = type_name.split("/")
    if len(parts) != 3 or parts[1] not in KINDS:
        meant = _meant(parts, prefixes)
        such = f"; write {meant!r}" if meant else " such as 'std_srvs/srv/Trigger'"
        raise DocumentError(f"is neither a .msg, .srv or .action file nor a type{such}", type_name)
    package, kind, name = parts
    share = share_folder(package, search_path(prefixes))
    if share is None:
        hint = package_like(package, search_path(prefixes))
        raise DocumentError(f"no package {package!r} is installed or built here{hint and '; ' + hint}", type_name)
    file = share / kind / f"{name}.{kind}"
    if not file.is_file():
        known = sorted(f.stem for f in (share / kind).glob(f"*.{kind}"))
        has = ", ".join(known[:20]) or "none"
        raise DocumentError(f"{package} has no {kind} {name!r}{nearest(name, known)} (it has: {has})", type_name)
    return file


def _meant(parts: Sequence[str], prefixes: Sequence[Path]) -> str:
    """Return the whole name of an installed type that was written without its kind, or with another word for it."""
    share = share_folder(parts[0], search_path(prefixes))
    kinds = [kind for kind in KINDS if share is not None and (share / kind / f"{parts[-1]}.{kind}").is_file()]
    return f"{parts[0]}/{kinds[0]}/{parts[-1]}" if kinds else ""


def _package_of(path: Path) -> str:
    folder = path.parent.parent
    return read_package(folder).name if (folder / "package.xml").is_file() else folder.name


def _parser() -> Any:
    try:
        from rosidl_adapter import parser
    except ImportError:
        raise MissingPartError("rosidl_adapter (ROS 2's interface parser)", "pip install 'grip-bt[ros]'") from None
    return parser


def _split(text: str, kind: str, source: str) -> list[tuple[int, list[str]]]:
    """Return each section as (number of its first line, its lines)."""
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
