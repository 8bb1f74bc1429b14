"""Compiled plans: trees of py_trees, ticked without generators."""

from .plan import Plan

__all__ = ["Plan"]
