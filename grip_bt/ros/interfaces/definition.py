"""Interface files read by rosidl's own parser, with the line of what is wrong, which that parser doesn't tell."""

from __future__ import annotations

import contextlib
import io
import keyword
from codecs import BOM_UTF8
from collections.abc import Sequence, Set
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
from grip_bt.task.catalog.component_file import Kind
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

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
        DocumentError: it can't be read, or isn't UTF-8 text as ROS wants it, without a byte order mark.
    """
    try:
        data = path.read_bytes()
        if data.startswith(BOM_UTF8):
            raise DocumentError("begins with a byte order mark, which ROS can't read: save it without", str(path), 1)
        return data.decode("utf-8")
    except OSError as error:
        raise DocumentError(f"can't be read: {error.strerror}", str(path)) from None
    except UnicodeDecodeError as error:
        line, reason = data.count(b"\n", 0, error.start) + 1, f"isn't UTF-8 text: byte 0x{data[error.start]:02x}"
        raise DocumentError(f"{reason}; save it as UTF-8", str(path), line) from None


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
    package, kind, name = (*type_name.split("/"), "", "")[:3]
    if kind not in KINDS or type_name.count("/") != 2:
        raise DocumentError(
            "is neither a .msg, .srv or .action file nor a type such as 'std_srvs/srv/Trigger'", type_name
        )
    share = share_folder(package, search_path())
    if share is None:
        hint = package_like(package, search_path())
        raise DocumentError(f"no package {package!r} is installed or built here{hint}", type_name)
    file = share / kind / f"{name}.{kind}"
    if not file.is_file():
        known = sorted(f.stem for f in (share / kind).glob(f"*.{kind}"))
        has = listing(known[:20])
        raise DocumentError(f"{package} has no {kind} {name!r}{nearest(name, known)} (it has: {has})", type_name)
    return file


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
    error: Exception | None = None
    for count in (len(lines), *range(1, len(lines) + 1)):  # the parser doesn't tell which line it is
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                spec = parse(package, name, "\n".join(lines[:count]))
        except Exception as reason:  # noqa: BLE001 - the parser raises its own and builtin errors alike
            if error is not None:
                line, words = lines[count - 1].strip(), str(reason)
                told = _WORDS.get(type(reason).__name__, words)
                raise DocumentError(f"{told}, in {line!r}", source, first + count - 1) from None
            error = reason
        else:
            if error is None:
                return spec
    raise DocumentError(str(error), source, first)


_WORDS = {
    "InvalidFieldDefinition": "a field is written as 'type name', a constant as 'type NAME=value'",
    "InvalidResourceName": "the first word isn't a type: a primitive, or Package/Message",
}
"""What errors of the parser mean that say little themselves."""


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


def check_package(package: Package, prefixes: Sequence[Path], beside: Set[str] = frozenset()) -> None:
    """Read every interface of a package and check that it can be built.

    Args:
        beside: names of the packages that are built with it.

    Raises:
        DocumentError: a file is wrong; it says which, where and why.
    """
    own = {f.stem for f in package.files if f.suffix == ".msg"}
    for file in package.files:
        path = package.folder / file
        spec = parse_interface(read_text(path), package.name, file.suffix[1:], file.stem, str(path))
        for field in (*spec.request, *spec.response, *spec.feedback):
            if keyword.iskeyword(field.name):
                told = f"it is a keyword of Python; rename it, for example to '{field.name}_value'"
                raise _wrong(spec, field, told)
            _check_type(spec, field, own, prefixes, beside - package.depends)


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
    if field.type in ("time", "duration"):
        raise _wrong(spec, field, f"{field.type!r} is of ROS 1; ROS 2 has builtin_interfaces/{field.type.title()}")
    if "/" not in field.type:
        return
    package, _, message = field.type.partition("/msg/")
    if message == "Header" and package == spec.package and message not in own:
        told = "a `Header` without its package is of ROS 1; ROS 2 has std_msgs/Header"
        raise _wrong(spec, field, f"{told}, for which package.xml has to ask: <depend>std_msgs</depend>")
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


def _wrong(spec: InterfaceSpec, field: FieldSpec, told: str) -> DocumentError:
    return DocumentError(f"field {field.name!r}: {told}", spec.source, _line_of(field, spec.source))


def _line_of(field: FieldSpec, source: str) -> int | None:
    for number, line in enumerate(read_text(Path(source)).splitlines(), 1):
        words = line.partition("#")[0].split()
        if len(words) >= 2 and words[1] == field.name:
            return number
    return None
