"""From descriptions to ordinary source files: an external component becomes a node package."""

from .contract import check_contract
from .render import render
from .write import outdated, write_package

__all__ = ["check_contract", "outdated", "render", "write_package"]
