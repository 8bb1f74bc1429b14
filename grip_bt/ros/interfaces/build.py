"""Build interface packages, once per content: each lands in `<cache>/<hash>/`, a prefix of its own.

Packages that aren't on PyPI are written in `ros/definitions/` from their documented fields, and built when they are
needed; what is installed, sourced or built by the user comes first. Type hashes are equal to those of the releases
named in `docs/launching.md`, as far as they are documented; a server of another release is refused.
"""

from __future__ import annotations

import fcntl
import hashlib
import importlib.util
import os
import platform
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from grip_bt.base.errors import NotWritableError, UnknownNameError
from grip_bt.ros.interfaces.definition import check_package
from grip_bt.ros.interfaces.packages import Package, activate, child_paths, find_packages, search_path, share_folder

from .compiler import compile_sources, compilers, install_package
from .generate import generate

_RECIPE = "1"
"""Raised when this builder produces something else from the same files."""


@dataclass(frozen=True)
class Built:
    """One built package; `seconds`: how long the build took; 0 when it was in the cache."""

    package: str
    prefix: Path
    seconds: float

    @property
    def cached(self) -> bool:
        return self.seconds == 0


def default_cache() -> Path:
    """Return the user's cache of built interfaces, below $XDG_CACHE_HOME."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "grip" / "interfaces"


def build_interfaces(
    folder: str | Path,
    cache: Path | None = None,
    overlays: Sequence[Path] = (),
    begun: Callable[[str], None] = lambda package: None,
    progress: Callable[[int, int, str], None] = lambda done, every, package: None,
) -> list[Built]:
    """Build the interface packages in a folder, those that others need first.

    Args:
        cache: where built packages are kept; the user's cache by default.
        overlays: prefixes with further packages that these need.
        begun: told the name of each package that isn't in the cache, before it is built.
        progress: told how many packages are there, of how many, and which comes next.

    Raises:
        DocumentError: a file of a package is wrong; it says which, where and why.
        MissingPartError: no compiler, or the generators aren't installed.
        InterfaceBuildError: the compiler failed.
        NotWritableError: the cache can't be written.
    """
    cache = (cache or default_cache()).resolve()
    prefixes = search_path(overlays)
    built: list[Built] = []
    hashes: dict[str, str] = {}
    packages = find_packages(Path(folder))
    beside = {package.name for package in packages}
    for package in packages:
        check_package(package, prefixes, beside)
        progress(len(built), len(packages), package.name)
        needed = [hashes.get(name) or _installed_hash(name, prefixes) for name in sorted(package.depends)]
        digest = hashes[package.name] = content_hash(package, list(filter(None, needed)))
        prefix = cache / digest
        started = time.monotonic()
        if not prefix.is_dir():
            begun(package.name)
        cached = _build(package, prefix, prefixes)
        built.append(Built(package.name, prefix, 0.0 if cached else time.monotonic() - started))
        prefixes.insert(0, prefix)
    return built


def content_hash(package: Package, needed: Sequence[str] = ()) -> str:
    """Return what identifies a build: files, the packages it needs, this Python, the machine and rosidl's version."""
    digest = hashlib.sha256()
    python = f"{sys.implementation.cache_tag}-{platform.machine()}-{sys.prefix}"
    for word in (_RECIPE, python, _rosidl_version(), *needed):
        digest.update(word.encode() + b"\0")
    for file in (Path("package.xml"), *package.files):
        digest.update(file.as_posix().encode() + b"\0" + (package.folder / file).read_bytes() + b"\0")
    return f"{package.name}-{digest.hexdigest()[:16]}"


def _installed_hash(package: str, prefixes: Sequence[Path]) -> str:
    """Return what identifies the types of a package that was built elsewhere, such as in an overlay that may change.

    Each of its type descriptions holds the hashes of all that the type nests.
    """
    share = share_folder(package, prefixes)
    if share is None or share.parent.parent == Path(sys.prefix):
        return ""
    digest = hashlib.sha256()
    for file in sorted(share.glob("*/*.json")):
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def _rosidl_version() -> str:
    try:
        return metadata.version("ros-rosidl-generator-py")
    except metadata.PackageNotFoundError:
        return os.environ.get("ROS_DISTRO", "unknown")


def _build(package: Package, prefix: Path, prefixes: Sequence[Path]) -> bool:
    """Build into `prefix` unless it is there; True when it was. Two processes may ask at once: one builds."""
    if prefix.is_dir():
        return True
    compilers()
    try:
        prefix.parent.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=prefix.parent).close()
    except OSError as error:
        advice = "built interfaces are kept there; set XDG_CACHE_HOME to a folder of yours"
        raise NotWritableError(prefix.parent, error, advice) from error
    with prefix.with_name(prefix.name + ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if prefix.is_dir():
            return True
        for left in prefix.parent.glob(f".{prefix.name}-*"):  # by a build that was killed
            shutil.rmtree(left, ignore_errors=True)
        with tempfile.TemporaryDirectory(prefix=f".{prefix.name}-", dir=prefix.parent) as work:
            target = Path(work) / "install"
            target.mkdir()
            generated = generate(package, Path(work) / "build", prefixes)
            objects = compile_sources(generated, prefixes, jobs=os.cpu_count() or 1)
            install_package(generated, objects, target, prefixes)
            shutil.move(target, prefix)
    return False


FOLDER = Path(__file__).parents[1] / "definitions"
DEPENDENCIES: dict[str, tuple[str, ...]] = {
    "grip_msgs": (),
    "control_msgs": (),
    "controller_manager_msgs": (),
    "tf2_msgs": (),
    "octomap_msgs": (),
    "simulation_interfaces": (),
    "smach_msgs": (),
    "object_recognition_msgs": (),
    "moveit_msgs": ("object_recognition_msgs", "octomap_msgs"),
}
"""Packages that are written here, and which of them each needs."""
_lock = threading.RLock()
_provided: dict[str, list[Path]] = {}


def ensure_package(package: str, cache: Path | None = None) -> list[Path]:
    """Make a package importable: as it is installed, else built from its definition, which takes some seconds once.

    Args:
        cache: where built packages are kept; the user's cache by default.

    Returns:
        the prefixes that were built, for processes that need it too; none when the package is installed.

    Raises:
        UnknownNameError: there is no such definition.
        MissingPartError: no compiler, or no generators.
        InterfaceBuildError: the compiler failed.
    """
    if package not in DEPENDENCIES:
        raise UnknownNameError("interface definition", package, DEPENDENCIES)
    with _lock:
        if package in _provided:
            return list(_provided[package])
        if importlib.util.find_spec(package) is not None:
            return []
        prefixes = [prefix for needed in DEPENDENCIES[package] for prefix in ensure_package(needed, cache)][::-1]
        (built,) = build_interfaces(FOLDER / package, cache, prefixes)
        activate(built.prefix)
        prefixes.insert(0, built.prefix)
        _provided[package] = prefixes
        return list(prefixes)


def shell_setup(*packages: str) -> str:
    """Return what a shell sources for its programs to find the interfaces that are served, and only this machine."""
    paths = child_paths([root for package in packages for root in ensure_package(package)])
    lines = ["# What is served here: source this in the shell of a client."]
    for variable, folders in paths.items():
        given = os.pathsep.join(str(folder) for folder in dict.fromkeys(folders))
        lines += [f'export {variable}="{given}${{{variable}:+:${variable}}}"'] if given else []
    settings = {name: os.environ.get(name, "") for name in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")}
    return "\n".join([*lines, *(f"export {name}={value}" for name, value in settings.items() if value), ""])
