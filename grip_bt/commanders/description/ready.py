"""The names of ready-made robots, and which packages bring their models."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

ROBOTS: Mapping[str, Path] = MappingProxyType(
    {file.stem: file for file in sorted((Path(__file__).parents[1] / "robots").glob("*.yaml"))}
)
"""Ready-made robot -> its file, which holds what `robot:` in a project file may hold. A new robot is a new file."""
EXTRAS: Mapping[str, str] = MappingProxyType(
    {"airo_models": "grippers", "gym_xarm": "grippers", "robopianist": "shadow", "example-robot-data": "motion"}
)
"""Package with models of ready-made robots -> our extra that brings it."""
