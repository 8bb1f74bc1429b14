"""Pictures of tasks: SVG with a layout of our own, and text for Graphviz and Mermaid."""

from .svg import to_svg
from .text import to_dot, to_mermaid

__all__ = ["to_dot", "to_mermaid", "to_svg"]
