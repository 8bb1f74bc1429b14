"""A task as Python source that builds its machine of SMACH."""

from .export import export

__all__ = ["export"]
