"""Pictures of tasks: SVG with a layout of our own, and text for Graphviz and Mermaid."""

from __future__ import annotations

from grip_bt.formats.draw.views import View
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog

from . import text
from .svg import svg
from .views import flow_figure, tree_figure

__all__ = ["View", "to_dot", "to_mermaid", "to_svg"]


def to_svg(task: Task, catalog: Catalog, view: View = "tree", paths: bool = False) -> str:
    """Return a picture of a task.

    Args:
        task: the task; it need not be valid.
        catalog: where the nodes' documentation is, for the titles that a pointer shows.
        view: `tree` (every node a box, order from top to bottom) or `flow` (containers as frames, links inside).
        paths: whether each node's group says its path (`data-path`), for pages that light nodes.
    """
    figure = tree_figure(task, catalog) if view == "tree" else flow_figure(task, catalog)
    return svg(figure, f"{task.name}, {view} view", paths)


def to_dot(task: Task, catalog: Catalog, view: View = "tree") -> str:
    """Return a task as a Graphviz graph."""
    return text.to_dot(task, view)


def to_mermaid(task: Task, catalog: Catalog, view: View = "tree") -> str:
    """Return a task as a Mermaid flow chart."""
    return text.to_mermaid(task, view)
