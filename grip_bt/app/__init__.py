"""The composition root: projects, which adapters a run gets, and running tasks."""

from typing import Any

from .project import Project, find_project, project_catalog

__all__ = ["Project", "RunOptions", "check_task", "find_project", "open_session", "project_catalog", "run", "tree_run"]


def __getattr__(name: str) -> Any:
    # What runs a task loads the compilers and py_trees; a project is read without them.
    if name in ("RunOptions", "check_task", "open_session", "run"):
        from . import execute

        return getattr(execute, name)
    if name == "tree_run":
        from .tree_parts import tree_run

        return tree_run
    raise AttributeError(f"module 'grip_bt.app' has no attribute {name!r}")
