"""Legacy SMACH files -> tasks: a static reading that runs nothing, and a recorded execution for what it can't see."""

from .advice import advice
from .files import ImportedFile, import_file, write_import
from .found import Problem, Span
from .live import FromMachine, from_machine
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
