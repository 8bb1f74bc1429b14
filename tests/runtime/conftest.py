"""Runs have the time that they need to end by themselves, also on a busy machine."""

from __future__ import annotations

import pytest

PATIENCE = 60.0
"""Far beyond what the end of any run takes that isn't hindered [s]."""


@pytest.fixture(autouse=True)
def unhurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave nothing behind, and terminate nothing from outside, only because a machine is slow."""
    for limit in ("INSIST", "ABANDON", "LAST_MOMENT"):
        monkeypatch.setattr(f"grip_bt.runtime.runner.{limit}", PATIENCE)
