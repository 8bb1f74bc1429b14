"""Shared memory of Fast DDS whose process is dead: a killed one leaves megabytes in /dev/shm, and nobody takes them.

Each segment has a lock file, which its process holds for as long as it lives, however it ends: who can lock it has
found a dead one's. (`fastdds shm clean`, which the wheels don't have, does the same.)
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import time
from pathlib import Path

FOLDER = Path("/dev/shm")
YOUNG = 10.0
"""Files that are younger are left alone [s]: between its creation and its lock, a segment looks dead."""
_LOCK = re.compile(r"^(fastrtps_(?:port\d+|[0-9a-f]{16}))_(?:el|sl)$")


def sweep(folder: Path = FOLDER, young: float = YOUNG) -> int:
    """Remove what dead processes of this user left; return how many segments.

    Args:
        folder: where shared memory is.
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
