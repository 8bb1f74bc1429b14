"""The C and Python sources of an interface package, by rosidl's generators.

Only their Python functions are used; the command `rosidl` of the wheels is broken (its entry points are doubled).
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError, MissingPartError
from grip_bt.ros.interfaces.packages import Package, share_folder

TYPESUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
"""Both are needed: with the first alone services work, but topics and actions can't register their types."""

_INCLUDE = re.compile(r'^#include "([a-z0-9_]+)/', re.MULTILINE)
_OF_EVERY_SERVICE = {"service_msgs", "builtin_interfaces"}
_OF_EVERY_ACTION = {"action_msgs", "unique_identifier_msgs"}


class InterfaceBuildError(GripError):
    """A generator, the compiler or the linker failed.

    Attributes:
        package: which package.
        command: what was run.
        output: what it said.
    """

    def __init__(self, package: str, command: Sequence[str], output: str):
        self.package, self.command, self.output = package, tuple(command), output
        lines = output.strip().splitlines()
        told = "\n".join(lines[:15] if len(lines) > 15 else lines)
        super().__init__(f"{package}: {Path(command[0]).name} failed:\n{told}")


@dataclass(frozen=True)
class Generated:
    """What was generated for a package.

    Attributes:
        package: what it was generated from.
        folder: holds `idl/`, `hash/` and one sub-folder per generator.
        idl: the .idl files, relative to `folder / "idl" / package.name`.
        depends: every package that it needs, also indirectly, with the prefix where it is installed.
    """

    package: Package
    folder: Path
    idl: tuple[Path, ...]
    depends: dict[str, Path]

    def sources(self, generator: str) -> list[Path]:
        """Return the C and C++ files of one generator."""
        root = self.folder / generator
        return sorted(p for suffix in ("*.c", "*.cpp") for p in root.rglob(suffix))


def generate(package: Package, folder: Path, prefixes: Sequence[Path]) -> Generated:
    """Generate all sources of `package` below `folder`.

    Raises:
        DocumentError: the package needs another one that isn't in `prefixes`.
        MissingPartError: the generators aren't installed.
        InterfaceBuildError: a generator failed.
    """
    generated = hash_types(package, folder, prefixes)
    with _quietly(package.name):
        _generate(generated, prefixes)
    return generated


@contextlib.contextmanager
def _quietly(package: str) -> Iterator[None]:
    """Keep what the generators print, and have them raise where they would end the process."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of the generators and their parser, not ours to mend
            yield
    except ModuleNotFoundError as error:
        raise MissingPartError(f"the interface generator {error.name}", "pip install 'grip-bt[ros]'") from None
    except GripError:
        raise
    except (Exception, SystemExit) as error:
        output = f"{said.getvalue()}\n{type(error).__name__}: {error}"
        raise InterfaceBuildError(package, ["the interface generator"], output) from error


def hash_types(package: Package, folder: Path, prefixes: Sequence[Path]) -> Generated:
    """Write only the interfaces (`idl/`) and the hashes of their types (`hash/`) below `folder`.

    Raises:
        DocumentError: the package needs another one that isn't in `prefixes`.
        MissingPartError: the generators aren't installed.
    """
    with _quietly(package.name):
        from rosidl_generator_type_description import generate_type_hash

        idl = _write_idl(package, folder / "idl" / package.name)
        texts = [(folder / "idl" / package.name / f).read_text(encoding="utf-8") for f in idl]
        generated = Generated(package, folder, idl, _dependencies(package, texts, prefixes))
        hashes = _arguments(generated, "rosidl_generator_type_description", folder / "hash" / package.name, prefixes)
        del hashes["type_description_tuples"]
        hashes["include_paths"] = [f"{d}:{prefix / 'share' / d}" for d, prefix in generated.depends.items()]
        with _argument_file(hashes) as file:
            generate_type_hash(file)
        return generated


def _generate(generated: Generated, prefixes: Sequence[Path]) -> None:
    package, folder = generated.package, generated.folder
    for generator, run in _generators().items():
        output = folder / generator / package.name
        for kind in {f.parts[0] for f in generated.idl}:
            (output / kind).mkdir(parents=True, exist_ok=True)
        _write_visibility(package.name, generator, output, prefixes)
        with _argument_file(_arguments(generated, generator, output, prefixes)) as file:
            run(file)


def _generators() -> dict[str, Callable[[str], object]]:
    from rosidl_generator_c import generate_c
    from rosidl_generator_py import generate_py
    from rosidl_typesupport_c import generate_c as generate_typesupport
    from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c
    from rosidl_typesupport_introspection_c import generate_c as generate_introspection

    return {
        "rosidl_generator_c": generate_c,
        "rosidl_typesupport_fastrtps_c": generate_typesupport_fastrtps_c,
        "rosidl_typesupport_introspection_c": generate_introspection,
        "rosidl_typesupport_c": lambda file: generate_typesupport(file, list(TYPESUPPORTS)),
        "rosidl_generator_py": lambda file: generate_py(file, ["rosidl_typesupport_c"]),
    }


def _write_idl(package: Package, folder: Path) -> tuple[Path, ...]:
    from rosidl_adapter import convert_to_idl

    for file in package.files:
        (folder / file.parent).mkdir(parents=True, exist_ok=True)
        convert_to_idl(package.folder, package.name, file, folder)
    return tuple(f.with_suffix(".idl") for f in package.files)


def _dependencies(package: Package, texts: Sequence[str], prefixes: Sequence[Path]) -> dict[str, Path]:
    """Return every package that the .idl texts include, directly or not, and its prefix."""
    kinds = {f.parts[0] for f in package.files}
    todo = {name for text in texts for name in _INCLUDE.findall(text)} | _implied(kinds)
    found: dict[str, Path] = {}
    while todo:
        name = todo.pop()
        if name == package.name or name in found:
            continue
        share = share_folder(name, prefixes)
        if share is None:
            raise DocumentError(f"needs the package {name!r}, which isn't installed or built", str(package.folder))
        found[name] = share.parent.parent
        files = list(share.glob("*/*.idl"))
        todo |= {n for f in files for n in _INCLUDE.findall(f.read_text(encoding="utf-8"))}
        todo |= _implied({f.parent.name for f in files})
    return dict(sorted(found.items()))


def _implied(kinds: set[str]) -> set[str]:
    """Return the packages that a service or an action needs without naming them."""
    services = _OF_EVERY_SERVICE if kinds & {"srv", "action"} else set()
    return services | (_OF_EVERY_ACTION if "action" in kinds else set())


def _arguments(generated: Generated, generator: str, output: Path, prefixes: Sequence[Path]) -> dict[str, object]:
    """Return what the generators' argument files hold (see rosidl_pycommon.generate_files)."""
    name, folder = generated.package.name, generated.folder
    idl_folder = folder / "idl" / name
    share = share_folder(generator, prefixes)
    if share is None:
        raise MissingPartError(f"the interface generator {generator}", "pip install 'grip-bt[ros]'")
    return {
        "package_name": name,
        "output_dir": str(output),
        "template_dir": str(share / "resource"),
        "idl_tuples": [f"{idl_folder}:{f.as_posix()}" for f in generated.idl],
        "target_dependencies": [],
        "ros_interface_files": [str(generated.package.folder / f) for f in generated.package.files],
        "ros_interface_dependencies": sorted(
            f"{d}:{i}" for d, prefix in generated.depends.items() for i in (prefix / "share" / d).glob("*/*.idl")
        ),
        "type_description_tuples": [
            f"{f.as_posix()}:{folder}/hash/{name}/{f.with_suffix('.json').as_posix()}" for f in generated.idl
        ],
    }


@contextlib.contextmanager
def _argument_file(arguments: dict[str, object]) -> Iterator[str]:
    with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
        json.dump(arguments, file)
        file.flush()
        yield file.name


def _write_visibility(package: str, generator: str, output: Path, prefixes: Sequence[Path]) -> None:
    """Write the header with a package's export macros, for the generators that have one."""
    share = share_folder(generator, prefixes)
    template = share and share / "resource" / f"{generator}__visibility_control.h.in"
    if template is None or not template.is_file():
        return
    text = template.read_text(encoding="utf-8")
    for key, value in (("PROJECT_NAME", package), ("PROJECT_NAME_UPPER", package.upper())):
        text = text.replace(f"@{key}@", value)
    target = output / "msg" / template.stem
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(text, encoding="utf-8")
