"""The C and Python sources of an interface package, by the classes behind the command `rosidl`.

The command itself is broken in the wheels: its entry points are doubled.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from unittest import mock

from grip_bt.base.errors import GripError, MissingPartError
from grip_bt.ros.interfaces.packages import KINDS, Package

TYPESUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
"""Both are needed: with the first alone services work, but topics and actions can't register their types."""


class InterfaceBuildError(GripError):
    """A generator, the compiler or the linker failed."""

    def __init__(self, package: str, command: Sequence[str], output: str):
        self.package, self.command, self.output = package, tuple(command), output
        lines = output.strip().splitlines()
        told = "\n".join(lines[:15] if len(lines) > 15 else lines)
        super().__init__(f"{package}: {Path(command[0]).name} failed:\n{told}")


@dataclass(frozen=True)
class Generated:
    """What was generated for a package.

    Attributes:
        folder: holds `idl/`, `hash/` and one sub-folder per generator.
        idl: the .idl files, relative to `folder / "idl" / package.name`.
        depends: every package with interfaces that it may need, with the prefix where it is installed.
    """

    package: Package
    folder: Path
    idl: tuple[Path, ...]
    depends: dict[str, Path]

    @property
    def interfaces(self) -> list[str]:
        return [f"{self.folder / 'idl' / self.package.name}:{f.as_posix()}" for f in self.idl]

    @property
    def includes(self) -> list[str]:
        """The folders with the .idl files of the packages that it needs."""
        return [str(prefix / "share" / package) for package, prefix in self.depends.items()]

    def sources(self, generator: str) -> list[Path]:
        root = self.folder / generator
        return sorted(p for suffix in ("*.c", "*.cpp") for p in root.rglob(suffix))


def generate(package: Package, folder: Path, prefixes: Sequence[Path]) -> Generated:
    """Generate all sources of `package` below `folder`.

    Raises:
        MissingPartError: the generators aren't installed.
        InterfaceBuildError: a generator failed.
    """
    with _working(package.name, prefixes):
        generated = hash_types(package, folder, prefixes)
        from rosidl_generator_c.cli import GenerateC
        from rosidl_generator_py.cli import GeneratePython
        from rosidl_typesupport_c.cli import GenerateCTypesupport
        from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
        from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

        generators = {
            "rosidl_typesupport_fastrtps_c": GenerateFastRTPSCTypesupport(""),
            "rosidl_typesupport_introspection_c": GenerateIntrospectionCTypesupport(""),
            "rosidl_typesupport_c": GenerateCTypesupport("", typesupport_implementations=list(TYPESUPPORTS)),
            "rosidl_generator_py": GeneratePython("", typesupport_implementations=["rosidl_typesupport_c"]),
        }
        for name in ("rosidl_generator_c", *generators):
            for kind in {f.parts[0] for f in generated.idl}:
                (folder / name / package.name / kind).mkdir(parents=True, exist_ok=True)
        for name, generator in generators.items():
            generator.generate(package.name, generated.interfaces, generated.includes, folder / name / package.name)
        for kind in {f.parts[0] for f in generated.idl}:  # it tells hashes apart by their interfaces' last names alone
            interfaces = [file for file in generated.interfaces if f":{kind}/" in file]
            hashes = [
                folder / "hash" / package.name / f.with_suffix(".json") for f in generated.idl if f.parts[0] == kind
            ]
            output = folder / "rosidl_generator_c" / package.name
            GenerateC("").generate(package.name, interfaces, generated.includes, output, hashes)
    return generated


@contextlib.contextmanager
def _working(package: str, prefixes: Sequence[Path]) -> Iterator[None]:
    """Have generators find their templates, keep what they print, and have them raise where they would exit.

    Each of the six parses all files anew, which was a third of their time: here a file is parsed once.
    """
    said, before = io.StringIO(), os.environ.get("AMENT_PREFIX_PATH")
    os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(map(str, [*prefixes, sys.prefix]))
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of the generators and their parser, not ours to mend
            from rosidl_parser import parser

            with mock.patch.object(parser, "parse_idl_string", cache(parser.parse_idl_string)):
                yield
    except ModuleNotFoundError as error:
        raise MissingPartError(f"the interface generator {error.name}", "pip install 'grip-bt[ros]'") from None
    except GripError:
        raise
    except (Exception, SystemExit) as error:
        output = f"{said.getvalue()}\n{type(error).__name__}: {error}"
        raise InterfaceBuildError(package, ["the interface generator"], output) from error
    finally:
        os.environ.pop("AMENT_PREFIX_PATH")
        if before is not None:
            os.environ["AMENT_PREFIX_PATH"] = before


def hash_types(package: Package, folder: Path, prefixes: Sequence[Path]) -> Generated:
    """Write only the interfaces (`idl/`) and the hashes of their types (`hash/`) below `folder`.

    Raises:
        MissingPartError: the generators aren't installed.
    """
    with _working(package.name, prefixes):
        from rosidl_generator_type_description.cli import HashTypeDescription

        idl = _write_idl(package, folder / "idl" / package.name)
        shares = [share for prefix in reversed(prefixes) for share in (prefix / "share").glob("*")]
        there = {s.name: s.parent.parent for s in shares if any((s / kind).is_dir() for kind in KINDS)}
        there.pop(package.name, None)
        generated = Generated(package, folder, idl, there)
        hashes = folder / "hash" / package.name
        HashTypeDescription("").generate_type_hashes(package.name, generated.interfaces, generated.includes, hashes)
        return generated


def _write_idl(package: Package, folder: Path) -> tuple[Path, ...]:
    from rosidl_adapter import convert_to_idl

    for file in package.files:
        (folder / file.parent).mkdir(parents=True, exist_ok=True)
        convert_to_idl(package.folder, package.name, file, folder)
    return tuple(f.with_suffix(".idl") for f in package.files)
