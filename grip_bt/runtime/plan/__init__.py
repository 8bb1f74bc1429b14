"""Compiled plans: trees of py_trees, ticked without generators."""

from .plan import Plan
from .single import ticker

__all__ = ["Plan", "ticker"]
