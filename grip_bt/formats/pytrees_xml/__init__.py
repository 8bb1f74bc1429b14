"""py_trees 2.6's XML, in and out: what it can say of a task, exactly, and nothing else."""

from .reader import from_xml
from .writer import to_xml

__all__ = ["from_xml", "to_xml"]
