"""A task as a stand-alone Python file of py_trees."""

from .export import export

__all__ = ["export"]
