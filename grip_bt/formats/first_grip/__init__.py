"""Tasks and configurations of the first GRIP -> a project: read as data; nothing that is in them is run."""

from .importer import GripImport, import_grip
from .original import Note
from .project import write_files

__all__ = ["GripImport", "Note", "import_grip", "write_files"]
