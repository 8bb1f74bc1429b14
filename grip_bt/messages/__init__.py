"""Named, typed stores: joint states, poses, grasps, clouds, anything that a project keeps by name."""

from .store import Change, MessageStore

__all__ = ["Change", "MessageStore"]
