"""Servers that tests start in a process of their own, which GRIP doesn't watch."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def serving(
    program: Path, *arguments: str, domain: int, overlays: Sequence[Path] = ()
) -> Iterator[subprocess.Popen[str]]:
    """Run a Python program until the block ends; it has printed `serving` when this gives its process.

    Args:
        program: the file.
        arguments: of the program.
        domain: the DDS domain that it joins.
        overlays: prefixes with further packages that it needs.
    """
    from grip_bt.ros.command import child_environment

    process = subprocess.Popen(
        [sys.executable, str(program), *arguments],
        env=child_environment(overlays, domain),
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "serving\n", f"{program.name} didn't come up"
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
