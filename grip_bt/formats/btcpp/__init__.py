"""BehaviorTree.CPP 4's XML, in and out: what it can say of a task, exactly, and nothing else."""

from __future__ import annotations

from .importer import from_xml
from .project import read
from .writer import to_xml

__all__ = ["from_xml", "read", "to_xml"]
