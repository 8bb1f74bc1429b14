"""Pictures of tasks: SVG with a layout of our own, and text for Graphviz and Mermaid."""

from .svg import to_svg
from .text import to_dot, to_mermaid
from .views import View

__all__ = ["View", "to_dot", "to_mermaid", "to_svg"]
