"""From descriptions to ordinary source files: an external component becomes a node package."""

from grip_bt.codegen.render import outdated, write_package

from .contract import check_contract
from .render import component_manifest, render

__all__ = ["check_contract", "component_manifest", "outdated", "render", "write_package"]
