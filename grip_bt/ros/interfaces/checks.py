"""What rosidl's parser lets pass and a build would fail at, in words of the compiler: told here with file and line."""

from __future__ import annotations

import keyword
from collections.abc import Iterator, Sequence, Set
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from grip_bt.base.errors import DocumentError, nearest
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

from .ament import share_folder
from .definition import parse_interface, read_text
from .package import Package

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
        package: whose.
        prefixes: where other packages are installed.
        beside: names of the packages that are built with it.

    Raises:
        DocumentError: a file is wrong; it says which, where and why.
    """
    own = {f.stem for f in package.files if f.suffix == ".msg"}
    specs = []
    for file in package.files:
        path = package.folder / file
        specs.append(parse_interface(read_text(path), package.name, file.suffix[1:], file.stem, str(path)))
        for field in _fields(specs[-1]):
            _check_name(specs[-1], field)
            _check_type(specs[-1], field, own, prefixes, beside - package.depends)
    _check_circles([spec for spec in specs if spec.kind == "msg"])


def _fields(spec: InterfaceSpec) -> Iterator[FieldSpec]:
    yield from (*spec.request, *spec.response, *spec.feedback)


def _check_name(spec: InterfaceSpec, field: FieldSpec) -> None:
    if language := _RESERVED.get(field.name):
        raise _wrong(spec, field, f"a word of {language} can't name a field; '{field.name}_value' can")


def _check_type(
    spec: InterfaceSpec, field: FieldSpec, own: set[str], prefixes: Sequence[Path], unasked: Set[str]
) -> None:
    """Check that the message type of a field exists.

    Args:
        spec: the interface.
        field: of it.
        own: names of the messages of its own package.
        prefixes: where other packages are installed.
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
