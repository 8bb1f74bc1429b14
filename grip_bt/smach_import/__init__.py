"""Legacy SMACH files -> tasks: a static reading that runs nothing, and a recorded execution for what it can't see."""

from .files import ImportedFile, import_file, write_import
from .found import Problem, Span
from .recorded import import_with_execution

__all__ = ["ImportedFile", "Problem", "Span", "import_file", "import_with_execution", "write_import"]
