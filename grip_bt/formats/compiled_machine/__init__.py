"""Compiled machines -> graph, with the transitions as they are now."""

from .convert import RefusedMachineError, to_task

__all__ = ["RefusedMachineError", "to_task"]
