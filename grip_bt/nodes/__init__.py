"""Leaves and composites: py_trees behaviours that know only ports, messages and values."""

from .leaf import Leaf, OperationLeaf

__all__ = ["Leaf", "OperationLeaf"]
