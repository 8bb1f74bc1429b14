"""py_trees tree objects -> graph: what has an equal becomes it, what hasn't is refused by its name and place."""

from .convert import to_task
from .result import Imported, RefusedTreeError

__all__ = ["Imported", "RefusedTreeError", "to_task"]
