"""Legacy SMACH files -> tasks: a static reading that runs nothing, and a recorded execution for what it can't see."""

from .importer import ImportedFile, advice, import_file, write_import
from .objects import FromMachine, from_machine
from .reader.found import Problem, Span
from .recorded import import_with_execution

__all__ = [
    "FromMachine",
    "ImportedFile",
    "Problem",
    "Span",
    "advice",
    "from_machine",
    "import_file",
    "import_with_execution",
    "write_import",
]
