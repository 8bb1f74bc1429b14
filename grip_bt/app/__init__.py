"""The composition root: projects, which adapters a run gets, and running tasks."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .project import Project, find_project, project_catalog

__all__ = ["Project", "RunOptions", "check_task", "find_project", "open_session", "project_catalog", "run", "tree_run"]

# Each is loaded when it is first asked for: `grip --help` needs none of them, and a project is read without what
# runs a task, which loads the compilers and py_trees.
_HOME = {
    "Project": "project",
    "find_project": "project",
    "project_catalog": "project",
    "RunOptions": "execute",
    "check_task": "execute",
    "open_session": "execute",
    "run": "execute",
    "tree_run": "tree_parts",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'grip_bt.app' has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)
