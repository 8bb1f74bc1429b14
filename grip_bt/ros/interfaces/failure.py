"""A build that fails though its files could be read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grip_bt.base.errors import GripError


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
