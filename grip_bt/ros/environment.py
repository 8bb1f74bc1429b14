"""Which ROS this process has, its settings, its DDS domain, and what dead processes left."""

from __future__ import annotations

import contextlib
import fcntl
import importlib.util
import os
import re
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from grip_bt.base.errors import GripError, MissingPartError

DDS_PROFILE = Path(__file__).with_name("fastdds_profile.xml")
"""Settings of Fast DDS: a dead participant is noticed after 2.7 s, not 20 s, and a running one found in 0.5 s."""

_PROFILE_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_WHEELS_REMEDY = "pip install 'grip-bt[ros]' (x86-64 Linux with glibc 2.28 or newer)"
_MIXED_REMEDY = (
    "use one of the two: start from a shell in which no setup.bash of ROS was sourced "
    "(unset AMENT_PREFIX_PATH PYTHONPATH LD_LIBRARY_PATH ROS_DISTRO), "
    "or use an environment without the wheels (python3 -m venv --system-site-packages, then pip install grip-bt)"
)


@dataclass(frozen=True)
class RosEnvironment:
    """What ROS this process would use.

    Attributes:
        kind: `wheels` (from PyPI, in this environment), `sourced` (a system installation), `none`, or `mixed`, which is
            refused: libraries of the two would be loaded in one process, at random.
        remedy: what to do about it; empty when nothing.
    """

    kind: Literal["wheels", "sourced", "none", "mixed"]
    detail: str
    remedy: str = ""

    @property
    def usable(self) -> bool:
        return self.kind in ("wheels", "sourced")


def environment(env: Mapping[str, str] | None = None, wheels: Path | None | Literal["look"] = "look") -> RosEnvironment:
    """Tell which ROS this process has, without loading it.

    Args:
        env: environment variables; those of this process by default.
        wheels: folder of the installed wheels' rclpy, or None; looked for by default.
    """
    env = os.environ if env is None else env
    found = _wheels() if wheels == "look" else wheels
    prefixes = [Path(p) for p in env.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]  # overlays hold no ROS
    sourced = [p for p in prefixes if p != Path(sys.prefix) and (p / "share" / "rclpy").is_dir()]
    if found and sourced:
        return RosEnvironment("mixed", f"ROS 2 wheels in {found} and a sourced ROS in {sourced[0]}", _MIXED_REMEDY)
    if found:
        return RosEnvironment("wheels", f"ROS 2 wheels in {found}")
    if sourced:
        return RosEnvironment("sourced", f"ROS 2 {env.get('ROS_DISTRO', '')} in {', '.join(map(str, sourced))}")
    return RosEnvironment("none", "no ROS 2 here", _WHEELS_REMEDY)


def require() -> RosEnvironment:
    """Return the environment's ROS. Raises MissingPartError: there is none, or two are mixed."""
    here = environment()
    if not here.usable:
        what = "ROS 2" if here.kind == "none" else f"one ROS 2 ({here.detail})"
        raise MissingPartError(what, here.remedy)
    return here


def prepare() -> None:
    """Set what must be set before rclpy or a message package is loaded; what the user has set stays.

    * ROS_PYTHON_CHECK_FIELDS=1: without it a field of a wrong type is sent as garbage.
    * discovery on this machine only, and our DDS profile.
    """
    os.environ["ROS_PYTHON_CHECK_FIELDS"] = "1"
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if not any(v in os.environ for v in _PROFILE_VARIABLES):
        os.environ |= dict.fromkeys(_PROFILE_VARIABLES, str(DDS_PROFILE))


def _wheels() -> Path | None:
    """Return the folder of rclpy when it is this Python environment's own."""
    spec = importlib.util.find_spec("rclpy")
    if spec is None or spec.origin is None:
        return None
    folder = Path(spec.origin).parent
    return folder if folder.is_relative_to(sys.prefix) else None


FOLDER = Path("/dev/shm")
YOUNG = 10.0
"""Files that are younger are left alone [s]: between its creation and its lock, a segment looks dead."""
_LOCK = re.compile(r"^(fastrtps_(?:port\d+|[0-9a-f]{16}))_(?:el|sl)$")


def sweep(folder: Path = FOLDER, young: float = YOUNG) -> int:
    """Remove what dead processes of this user left; return how many segments.

    Args:
        young: age below which a file is left alone [s].
    """
    removed = 0
    oldest = time.time() - young
    with contextlib.suppress(OSError):
        for entry in os.scandir(folder):
            found = _LOCK.match(entry.name)
            with contextlib.suppress(OSError):  # somebody else's, or gone meanwhile
                state = entry.stat(follow_symlinks=False)
                if found and entry.is_file() and state.st_uid == os.getuid() and state.st_mtime < oldest:
                    removed += _remove_if_dead(folder, found[1])
    return removed


def _remove_if_dead(folder: Path, segment: str) -> int:
    locks = [lock for kind in ("el", "sl") if (lock := folder / f"{segment}_{kind}").exists()]
    with contextlib.ExitStack() as stack:
        for lock in locks:  # one for a process that listens alone, one for those that share a port
            file = stack.enter_context(lock.open("rb"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return 0  # its process lives
        for path in (folder / segment, folder / f"sem.{segment}_mutex", *locks):
            path.unlink(missing_ok=True)
    return 1


DOMAINS = range(1, 101)
"""Above 101 the ports of a domain fall into the range that Linux hands out to anybody."""


@contextmanager
def own_domain() -> Iterator[int]:
    """Yield the user's ROS_DOMAIN_ID, or a domain that no other run on this machine has.

    Raises:
        GripError: all are taken.
    """
    chosen = os.environ.get("ROS_DOMAIN_ID")
    if chosen:
        yield int(chosen)
        return
    with free_domain() as domain:
        yield domain


@contextmanager
def free_domain(shift: int = 0) -> Iterator[int]:
    """Yield a domain that nobody else on this machine has from here, whatever ROS_DOMAIN_ID says.

    A domain is taken by a lock on a file, which the kernel gives back when the process ends, however it ends.

    Args:
        shift: where the search begins; who goes from domain to domain counts it up.

    Raises:
        GripError: all are taken.
    """
    for further in range(len(DOMAINS)):
        domain = DOMAINS[(os.getpid() + shift + further) % len(DOMAINS)]
        file = Path(tempfile.gettempdir()) / f"grip-ros-domain-{os.getuid()}-{domain}.lock"
        with file.open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    raise GripError(f"{len(DOMAINS)} runs already use ROS on this machine; end one, or set ROS_DOMAIN_ID")
