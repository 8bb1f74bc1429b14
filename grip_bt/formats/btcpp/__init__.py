"""BehaviorTree.CPP 4's XML, in and out: what it can say of a task, exactly, and nothing else."""

from .importer import from_xml
from .result import ImportedFile
from .writer import to_xml

__all__ = ["ImportedFile", "from_xml", "to_xml"]
