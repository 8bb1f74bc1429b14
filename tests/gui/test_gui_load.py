"""The server under load: short forms of `benchmarks/gui_load.py`."""

from __future__ import annotations

import asyncio
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

FILE = Path(__file__).parents[2] / "benchmarks" / "gui_load.py"
GROWTH = 15.0
"""Memory that the server may take more after its first runs [MB]."""


@pytest.fixture(scope="module")
def load() -> ModuleType:
    spec = importlib.util.spec_from_file_location("gui_load", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["gui_load"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_twenty_viewers_miss_nothing_and_memory_stays_flat(load: ModuleType) -> None:
    seen = asyncio.run(load.soak(12.0, 20))
    assert seen["runs"] >= 2
    assert seen["events"] >= 20 * 200
    assert seen["memory_end"] - seen["memory_warm"] < GROWTH, seen


@pytest.mark.slow
def test_two_hundred_nodes_that_speak_thirty_times_a_second_are_all_seen(load: ModuleType) -> None:
    seen = asyncio.run(load.status(4.0, 1))
    assert seen["seen"] == seen["written"] + 1
    # A core that others use too is slower; the figure itself is in docs/benchmarks.md.
    assert seen["share_of_a_core"] < 0.5, seen


@pytest.mark.slow
def test_a_server_with_nothing_to_do_does_nothing(load: ModuleType) -> None:
    assert asyncio.run(load.idle(4.0, 3))["share_of_a_core"] < 0.02
