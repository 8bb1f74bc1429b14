"""Whether joints that somebody names are those of an arm."""

from __future__ import annotations

from collections.abc import Sequence

from grip_bt.errors import UnknownNameError


def require_joints(names: Sequence[str], allowed: Sequence[str], arm: str) -> None:
    """Verify that an arm has the joints that are named.

    Raises:
        UnknownNameError: it lacks one.
    """
    for name in names:
        if name not in allowed:
            raise UnknownNameError("joint", name, allowed, where=f"arm {arm!r}")
