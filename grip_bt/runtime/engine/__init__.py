"""The tick engine: trees of py_trees, ours or not, ticked by closures instead of generators."""

from .engine import TickEngine, make_ticker

__all__ = ["TickEngine", "make_ticker"]
