"""Legacy SMACH files -> tasks: a static reading that runs nothing, and a recorded execution for what it can't see."""

from .files import ImportedFile, import_file, write_import
from .found import Problem, Span

__all__ = ["ImportedFile", "Problem", "Span", "import_file", "write_import"]
