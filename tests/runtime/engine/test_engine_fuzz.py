"""The tick engine does what py_trees does, on random trees with edits between ticks."""

from __future__ import annotations

import os
from typing import Any

import pytest
from engine_pairs import compare

TREES = int(os.environ.get("GRIP_FUZZ_TREES", "5000"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 10
QUICK = 2
"""As many of them are looked at all day long."""

WAYS: list[dict[str, Any]] = [
    {},
    {"fixed": True},
    {"wild": False},
]
CALM: list[dict[str, Any]] = [
    {"edits": 0.05},
    {"edits": 0.0},
    {"edits": 0.1, "wild": False},
    {"edits": 0.05, "fixed": True},
]


@pytest.mark.parametrize(
    "chunk", [chunk if chunk < QUICK else pytest.param(chunk, marks=pytest.mark.slow) for chunk in range(CHUNKS)]
)
def test_the_engine_leaves_every_tree_as_py_trees_does(chunk: int) -> None:
    size = max(1, TREES // CHUNKS)
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        found = compare(seed, **WAYS[seed % len(WAYS)])
        assert found is None, found


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_the_engine_leaves_trees_that_settle_as_py_trees_does(chunk: int) -> None:
    size = max(1, TREES // CHUNKS // 10)
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        found = compare(seed, ticks=30, calm=True, **CALM[seed % len(CALM)])
        assert found is None, found
