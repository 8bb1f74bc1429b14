"""The generated sources of an interface package, compiled with gcc and laid out as an ordinary ROS prefix.

The package's `__init__.py` loads its own libraries by path: ROS later asks for them by bare name
(`dlopen("libX.so")`), and glibc then finds those already loaded. So nothing needs LD_LIBRARY_PATH.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from grip_bt.base.errors import MissingPartError

from .generate import TYPESUPPORTS, Generated, InterfaceBuildError

_RUNTIME = (
    "rosidl_runtime_c",
    "rcutils",
    "rosidl_typesupport_c",
    "rosidl_typesupport_fastrtps_c",
    "rosidl_typesupport_fastrtps_cpp",
    "rosidl_typesupport_introspection_c",
    "rmw",
    "fastcdr",
)
_LIBRARIES = ("rosidl_generator_c", *TYPESUPPORTS, "rosidl_typesupport_c", "rosidl_generator_py")
"""Shared libraries of a package, in the order in which they need each other."""


def compilers() -> tuple[str, str]:
    """Return the C and the C++ compiler: $CC and $CXX, else gcc and g++.

    Raises:
        MissingPartError: one of them, or Python's own header, isn't there.
    """
    found = []
    for variable, default in (("CC", "gcc"), ("CXX", "g++")):
        program = shutil.which(os.environ.get(variable, default))
        if program is None:
            raise MissingPartError(f"the compiler {os.environ.get(variable, default)!r}", "sudo apt install g++")
        found.append(program)
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        raise MissingPartError("Python.h", "sudo apt install python3-dev")
    return found[0], found[1]


def compile_sources(generated: Generated, prefixes: Sequence[Path], jobs: int) -> dict[str, list[Path]]:
    """Compile what the generators have made, several files at once; return the objects of each library.

    Sources of one kind are compiled some together, since most of the time goes into headers that all of them include;
    where a compiler refuses that (two interfaces of one name), one by one.

    Raises:
        MissingPartError: no compiler.
        InterfaceBuildError: the compiler failed.
    """
    flags = _flags(generated, prefixes)
    units = [unit for generator in _LIBRARIES for unit in _units(generated, generator, jobs)]
    found: dict[str, list[Path]] = {}
    with ThreadPoolExecutor(jobs) as pool:
        try:
            made = pool.map(lambda unit: _compile(generated, unit[0], unit[1], flags), units)
            for (library, _), objects in zip(units, made, strict=True):
                found.setdefault(library, []).extend(objects)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return found


def install_package(
    generated: Generated, objects: dict[str, list[Path]], target: Path, prefixes: Sequence[Path]
) -> None:
    """Link a compiled package and install it into the prefix `target`.

    Raises:
        InterfaceBuildError: the linker failed.
    """
    site = target / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    module = site / generated.package.name
    shutil.copytree(
        generated.folder / "rosidl_generator_py" / generated.package.name, module, ignore=shutil.ignore_patterns("*.c")
    )
    _link(generated, objects, target, module, prefixes)
    libraries = "".join(f'    "lib{generated.package.name}__{kind}.so",\n' for kind in _LIBRARIES)
    (module / "__init__.py").write_text(
        "import ctypes\nfrom pathlib import Path\n\n"
        "_lib = Path(__file__).resolve().parents[3]\n"
        f"_names = (\n{libraries})\n"
        "_loaded = [ctypes.CDLL(str(_lib / name), mode=ctypes.RTLD_GLOBAL) for name in _names]\n",
        encoding="utf-8",
    )
    _install_share(generated, target)


def _flags(generated: Generated, prefixes: Sequence[Path]) -> list[str]:
    name = generated.package.name
    return [
        "-fPIC",
        "-O1",
        "-w",
        "-DNDEBUG",  # else a field of the wrong type is a C assert, which aborts the process
        f'-DROS_PACKAGE_NAME="{name}"',
        *(f"-D{g.upper()}_BUILDING_DLL_{name}" for g in ("rosidl_generator_c", *TYPESUPPORTS)),
        *(f"-I{folder}" for folder in _include_folders(generated, prefixes)),
    ]


def _compile(generated: Generated, library: str, sources: Sequence[Path], flags: Sequence[str]) -> list[Path]:
    """Compile sources into one object, or into one each where they can't stand together."""
    cc, cxx = compilers()
    folder = generated.folder / "objects" / library
    folder.mkdir(parents=True, exist_ok=True)
    first = sources[0]
    language = [cxx, "-std=c++17"] if first.suffix == ".cpp" else [cc, "-std=gnu11"]
    target = folder / ("_".join(first.parts[-3:]) + ".o")
    if len(sources) == 1:
        _run(generated.package.name, [*language, *flags, "-c", str(first), "-o", str(target)])
        return [target]
    together = target.with_suffix(first.suffix)
    together.write_text("".join(f'#include "{source}"\n' for source in sources), encoding="utf-8")
    try:
        return _compile(generated, library, [together], flags)
    except InterfaceBuildError:
        return [made for source in sources for made in _compile(generated, library, [source], flags)]


def _units(generated: Generated, generator: str, jobs: int) -> Iterator[tuple[str, list[Path]]]:
    """Yield sources that are compiled together, with the library that they go into.

    `extension` is the module that Python imports. Sources of one folder and one ending (such as `__functions.c`) have
    names of their own, except descriptions, which repeat those of what they nest.
    """
    kinds: dict[tuple[Path, str], list[Path]] = {}
    for source in generated.sources(generator):
        if ".ep." in source.name:
            yield "extension", [source]
        elif "__description" in source.name:
            yield generator, [source]
        else:
            _, named, kind = source.stem.rpartition("__")
            kinds.setdefault((source.parent, kind + source.suffix if named else source.suffix), []).append(source)
    for sources in kinds.values():
        parts = min(jobs, -(-len(sources) // 4))
        for part in range(parts):
            yield generator, sources[part::parts]


def _include_folders(generated: Generated, prefixes: Sequence[Path]) -> Iterator[Path]:
    for generator in _LIBRARIES[:-1]:
        yield generated.folder / generator
    yield Path(sysconfig.get_path("include"))
    yield Path(np.get_include())
    for prefix in prefixes:
        include = prefix / "include"
        if include.is_dir():  # headers of package p are in include/p/p, as ROS 2 installs them
            yield from sorted(p for p in include.iterdir() if (p / p.name).is_dir())
            yield include


def _link(
    generated: Generated, objects: dict[str, list[Path]], target: Path, module: Path, prefixes: Sequence[Path]
) -> None:
    _, cxx = compilers()
    name, lib = generated.package.name, target / "lib"
    search = [f for r in prefixes if (r / "lib").is_dir() for f in (f"-L{r}/lib", f"-Wl,-rpath,{r}/lib")]
    common = [*search, f"-L{lib}", "-Wl,--as-needed", "-Wl,-s"]
    runtime = [f"-l{r}" for r in _RUNTIME]

    def of_dependencies(kind: str) -> list[str]:
        return [f"-l{d}__{kind}" for d, p in generated.depends.items() if (p / "lib" / f"lib{d}__{kind}.so").exists()]

    def link(output: Path, files: list[Path], *more: str) -> None:
        _run(name, [cxx, "-shared", "-o", str(output), *map(str, files), *common, *more, *runtime])

    generator_c = f"-l{name}__rosidl_generator_c"
    typesupport = f"-l{name}__rosidl_typesupport_c"
    for kind in _LIBRARIES:
        own = [] if kind == "rosidl_generator_c" else [generator_c]
        own += [typesupport] if kind == "rosidl_generator_py" else []
        file = f"lib{name}__{kind}.so"
        needed = [*own, *of_dependencies("rosidl_generator_c"), *of_dependencies(kind)]
        link(lib / file, objects[kind], f"-Wl,-soname,{file}", "-Wl,-rpath,$ORIGIN", *needed)
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    needed = [f"-l{name}__rosidl_generator_py", typesupport, generator_c]
    needed += [*of_dependencies("rosidl_generator_c"), *of_dependencies("rosidl_generator_py")]
    extension = module / f"{name}_s__rosidl_typesupport_c{suffix}"
    link(extension, objects["extension"], "-Wl,-rpath,$ORIGIN/../../..", *needed)


def _install_share(generated: Generated, target: Path) -> None:
    """Install interface files, type hashes, headers (for packages that nest ours) and the ament index."""
    package, folder = generated.package, generated.folder
    share = target / "share" / package.name
    for file, idl in zip(package.files, generated.idl, strict=True):
        (share / file.parent).mkdir(parents=True, exist_ok=True)
        shutil.copy(package.folder / file, share / file)
        shutil.copy(folder / "idl" / package.name / idl, share / idl)
        json = idl.with_suffix(".json")
        shutil.copy(folder / "hash" / package.name / json, share / json)
    shutil.copy(package.folder / "package.xml", share)
    only_headers = shutil.ignore_patterns("*.c", "*.cpp")
    for generator in ("rosidl_generator_c", *TYPESUPPORTS):
        include = target / "include" / package.name
        shutil.copytree(folder / generator, include, dirs_exist_ok=True, ignore=only_headers)
    index = target / "share" / "ament_index" / "resource_index"
    files = sorted(f.as_posix() for f in (*package.files, *generated.idl))
    for kind, text in (("packages", ""), ("rosidl_interfaces", "\n".join(files))):
        (index / kind).mkdir(parents=True, exist_ok=True)
        (index / kind / package.name).write_text(text, encoding="utf-8")


def _run(package: str, command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InterfaceBuildError(package, command, done.stderr or done.stdout)
