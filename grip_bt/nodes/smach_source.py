"""Legacy Python files: read as they are, converted in memory from Python 2, imported under own names."""

from __future__ import annotations

import ast
import importlib
import logging
import os
import re
import sys
import threading
import tokenize
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import sha256
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from grip_bt import smach_compat
from grip_bt.base.errors import DocumentError
from grip_bt.commanders.description.packages import name_of_package

_TAB = 8
"""Columns of a tab, which Python 2 allowed to be mixed with spaces."""

# Old spellings only: nothing here changes what Python 3 code means. Fixers that wrap calls in list(...) are needed,
# since Python 2 code indexes what dict.keys(), map and filter return.
_FIXERS = (
    *("apply", "basestring", "dict", "except", "exec", "execfile", "filter", "funcattrs", "has_key", "idioms"),
    *("imports", "intern", "itertools", "itertools_imports", "long", "map", "methodattrs", "ne", "next", "nonzero"),
    *("numliterals", "paren", "print", "raise", "raw_input", "reduce", "repr", "standarderror", "throw"),
    *("tuple_params", "unicode", "urllib", "xrange", "zip"),
)


_PYTHON_2 = re.compile(r"\.(iteritems|iterkeys|itervalues|has_key)\(|\b(xrange|raw_input)\(|\bbasestring\b")
"""What no Python 3 has, and what its syntax takes all the same."""


@dataclass(frozen=True)
class Source:
    """A file that can be parsed: its text in Python 3 and its syntax, with the file's own line numbers."""

    path: Path
    text: str
    tree: ast.Module
    converted: bool


def read_source(path: Path) -> Source:
    """Read a Python file of any age. Raises DocumentError: it can't be read, or is neither Python 3 nor Python 2."""
    try:
        with tokenize.open(path) as file:
            text = file.read()
    except (OSError, SyntaxError, UnicodeDecodeError) as error:
        raise DocumentError(f"can't be read: {error}", str(path)) from error
    try:
        tree = _parse(text, path)
        if _PYTHON_2.search(text):
            raise ValueError("is written for Python 2")
        return Source(path, text, tree, False)
    except (SyntaxError, ValueError) as first:
        try:
            whole = text.expandtabs(_TAB)
            with _converting:
                converted = str(_converter().refactor_string(whole + "\n" * (whole[-1:] != "\n"), str(path)))
            return Source(path, converted, _parse(converted, path), True)
        except Exception:  # noqa: BLE001 - the converter raises whatever it likes; the first error says what is wrong
            line = getattr(first, "lineno", None)
            raise DocumentError(f"is neither Python 3 nor Python 2: {first}", str(path), line) from first


def _parse(text: str, path: Path) -> ast.Module:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # invalid escapes in old regular expressions
        tree = ast.parse(text)
    return _Neighbours(path).visit(tree) if "." in package_of(path)[1] else tree


class _Neighbours(ast.NodeTransformer):
    """Has a module import what lies beside it from its package, as Python 2 did by the name alone.

    Modules of one name in several packages stay apart so.
    """

    def __init__(self, path: Path):
        self.folder, self.there, self.own = path.parent, names_in(path.parent), package_of(path)[1].split(".")[0]

    def _is_beside(self, name: str) -> bool:
        top, _, below = name.partition(".")
        module = f"{top}.py" in self.there and not below
        package = top in self.there and "__init__.py" in names_in(self.folder / top)
        return (module or package) and top != self.own and top not in sys.stdlib_module_names

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.ImportFrom:
        node.level = node.level or int(self._is_beside(node.module or ""))
        return node

    def visit_Import(self, node: ast.Import) -> list[ast.stmt]:
        near = [each for each in node.names if "." not in each.name and self._is_beside(each.name)]
        each_alone = (ast.ImportFrom(None, [n], 1) if n in near else ast.Import([n]) for n in node.names)
        return [ast.copy_location(each, node) for each in each_alone]


_converting = threading.Lock()  # the converter has sys.stderr be another one for a while


@lru_cache
def _converter() -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # lib2to3 leaves Python with 3.13
        from lib2to3.refactor import RefactoringTool

    logging.getLogger("RefactoringTool").setLevel(logging.ERROR)
    logging.getLogger("lib2to3.main").setLevel(logging.ERROR)
    return RefactoringTool([f"lib2to3.fixes.fix_{name}" for name in _FIXERS])


_HIGHEST = 5
"""How many folders above a package a workspace may begin."""
_BUILT = ("build", "install", "devel", "log")
_MANIFESTS = ("package.xml", "manifest.xml")  # the second one is rosbuild's


@dataclass(frozen=True)
class Workspace:
    """The packages that lie together, by name; the folder around them; where modules are looked for.

    For each of its files there are `folders` of its own before the `shared` ones.
    """

    root: Path
    shared: tuple[Path, ...]
    packages: Mapping[str, Path]
    folders: tuple[Path, ...] = ()


def workspace_of(file: Path, bound: Path | None = None) -> Workspace:
    """Return the workspace around a file, found by its packages' manifests; `bound`: its folder, if known.

    Of packages of one name the file's own counts.
    """
    package = next((p for p in file.parents if any((p / name).is_file() for name in (*_MANIFESTS, "setup.py"))), None)
    root = bound or (_root(package) if package is not None else file.parent)
    whole = _workspace(root, package is not None or bound is not None)
    own = {} if package is None else {name_of_package(package) or package.name: package}
    home, name = package_of(file)
    hidden = f"{name.split('.')[0]}.py" in names_in(file.parent)  # the package, by a module of its name in it
    near = (home, file.parent) if hidden else (file.parent, home)
    folders = tuple(dict.fromkeys((*near, *whole.shared)))
    return replace(whole, packages={**whole.packages, **own}, folders=folders)


@lru_cache(maxsize=64)
def _workspace(root: Path, packaged: bool) -> Workspace:
    """Return a workspace as it is for all of its files."""
    packages, folders = {}, list[Path]()
    for folder in _packages(root) if packaged else ():
        packages[name_of_package(folder) or folder.name] = folder
        folders += _module_folders(folder)
    folders += [root, root / "src", *sorted(root.glob("*/src"))]
    return Workspace(root, tuple(dict.fromkeys(f for f in folders if f.is_dir())), packages)


def _root(package: Path) -> Path:
    above = package.parents[:_HIGHEST]
    for folder in above:
        if folder.name == "src" and any((folder.parent / name).is_dir() for name in _BUILT):
            return folder
    for folder in (package, *above):
        if (folder / ".git").exists():
            return folder
    root = package
    for folder in above:
        if not any(p.parent != root for p in folder.glob("*/package.xml")):
            break
        root = folder
    return root


def _packages(root: Path) -> Iterator[Path]:
    for at, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if f[0] != "." and f not in (*_BUILT, "node_modules"))
        if {*_MANIFESTS} & {*files} or ("setup.py" in files and Path(at) != root):
            yield Path(at)


def _module_folders(package: Path) -> list[Path]:
    """Return where a package's `setup.py` has its modules, and where they are by custom."""
    try:
        text = (package / "setup.py").read_text(errors="replace")
    except OSError:
        text = ""
    said = re.search(r"package_dir['\"]?\s*[=:]\s*\{([^}]*)\}", text)
    pairs = re.findall(r"['\"]([\w.]*)['\"]\s*:\s*['\"]([^'\"]+)", said.group(1)) if said else []
    named = [package / folder if not name else (package / folder).parent for name, folder in pairs]
    return [*named, package / "src", package]


def names_in(folder: Path) -> frozenset[str]:
    """Return the names of what is in a folder; none where there is no such folder."""
    try:
        return frozenset(os.listdir(folder))
    except OSError:
        return frozenset()


def code_of(file: Path) -> CodeType:
    """Return the code of a file; see `read_source`."""
    return compile(read_source(file).tree, str(file), "exec")


class LegacyFinder(MetaPathFinder, Loader):
    """Finds the modules of folders, of any age of Python.

    Attributes:
        compiled: gives the code of a file; `listed`: the names that are in a folder.
    """

    compiled, listed = staticmethod(code_of), staticmethod(names_in)

    def __init__(self, folders: Iterable[Path]):
        self.folders = list(folders)

    def find_spec(self, fullname: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        """Find a module or package; a folder that only has its name is one if it has modules and no manifest."""
        last = fullname.rpartition(".")[2]
        folders = self.folders if path is None else [*map(Path, path)]
        names = {last, f"{last}.py"}
        folders = [folder for folder in folders if not names.isdisjoint(self.listed(folder))]
        for folder in folders:
            package = "__init__.py" in self.listed(folder / last)
            if package or f"{last}.py" in self.listed(folder):
                file = folder / last / "__init__.py" if package else folder / f"{last}.py"
                below = [str(file.parent)] if package else None
                return spec_from_file_location(fullname, file, loader=self, submodule_search_locations=below)
        parts = [str(folder / last) for folder in folders if _has_modules(self.listed(folder / last))]
        spec = ModuleSpec(fullname, self, origin=parts[0], is_package=True) if parts else None
        if spec is not None:
            spec.submodule_search_locations = parts
        return spec

    def create_module(self, spec: ModuleSpec) -> None:
        """Have the usual kind of module made."""

    def exec_module(self, module: ModuleType) -> None:
        """Execute it, unless it is only a folder."""
        if "__file__" in vars(module):
            exec(self.compiled(Path(str(module.__file__))), module.__dict__)


def _has_modules(names: frozenset[str]) -> bool:
    return not names & {*_MANIFESTS, "setup.py"} and any(name.endswith(".py") for name in names)


def package_of(path: Path) -> tuple[Path, str]:
    """Return the folder in which a file's package lies, and the file's name as a module of that folder."""
    folder, names = path.parent, [path.stem]
    while (folder / "__init__.py").is_file() and not names_in(folder.parent if folder.name == "src" else folder) & {
        *_MANIFESTS
    }:
        folder, names = folder.parent, [folder.name, *names]
    return folder, ".".join(names)


def module_name(path: Path) -> str:
    """Return the name under which a file is imported: its own in its package, which relative imports need."""
    name = package_of(path)[1]
    packaged = "." in name and name.split(".")[0] not in sys.stdlib_module_names  # a folder `test` is none of Python's
    return name if packaged else f"grip_legacy_{sha256(str(path).encode()).hexdigest()[:12]}"


class LegacySubmodules(MetaPathFinder):
    """Comes first, for what lies in packages that a legacy finder has found: it may be as old as they are."""

    def find_spec(self, fullname: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        loader = getattr(sys.modules.get(fullname.rpartition(".")[0]), "__loader__", None)
        return loader.find_spec(fullname, path) if isinstance(loader, LegacyFinder) else None


_finder = LegacyFinder(())


def prepare_imports(path: Path, ros: bool = True) -> None:
    """Have a legacy file find `smach`, `rospy`, its neighbours, and the packages of its workspace, after all others."""
    smach_compat.install(ros=ros, rospy=ros)
    for folder in workspace_of(path).folders:
        if folder not in _finder.folders:
            _finder.folders.append(folder)
    if _finder not in sys.meta_path:
        sys.meta_path.append(_finder)
        sys.meta_path.insert(0, LegacySubmodules())


def load_legacy(path: Path, ros: bool = True) -> ModuleType:
    """Import a legacy file, once per process; see `prepare_imports`.

    Args:
        path: the file.
        ros: whether it gets a `smach_ros` that works; else it gets what the process has.

    Raises:
        DocumentError: see `read_source`.
        GripError: another `smach` is loaded already.
        Exception: whatever the file raises when it is imported.
    """
    path = path.resolve()
    name = module_name(path)
    there = sys.modules.get(name)
    if there is not None and getattr(there, "__file__", None) == str(path):
        return there
    code = code_of(path)
    prepare_imports(path, ros)
    if "." in name:
        return importlib.import_module(name)
    try:
        return run_as(name, path, code)
    except BaseException:
        del sys.modules[name]
        raise


def run_as(name: str, path: Path, code: CodeType, modules: dict[str, ModuleType] = sys.modules) -> ModuleType:
    """Run a file as the module of this name; as `__main__` it imports the neighbours in its package, as with `-m`."""
    module = modules[name] = ModuleType(name)
    module.__file__, module.__package__ = str(path), module_name(path).rpartition(".")[0] or None
    exec(code, module.__dict__)
    return module
