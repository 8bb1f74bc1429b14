"""What the build of a wheel or of a source distribution adds: the documentation, where `make docs` has built it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SITE = "build/site"


class Documentation(BuildHookInterface):
    """Takes in the built site; an editable installation finds it where it lies."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the folder and its place in what is built."""
        site = Path(self.root) / SITE
        if version != "editable" and (site / "index.html").is_file():
            build_data["force_include"][str(site)] = SITE if self.target_name == "sdist" else "grip_bt/_docs"
