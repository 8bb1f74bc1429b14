"""A DDS domain for one run, so that runs beside each other don't hear one another."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from grip_bt.base.errors import GripError

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
