"""Named, typed stores: joint states, poses, grasps, clouds, anything that a project keeps by name.

    from grip_bt.base.message_store import MessageLibrary
    library = MessageLibrary("messages")          # the files of a project
    library.store("poses").get("bin")

The same over ROS 2, for other processes and languages: `grip_bt.ros.messages`.
"""

from .files import read_joint_states, read_poses, read_trajectories
from .library import STANDARD, LocalMessages, MessageLibrary
from .store import ArchiveError, Change, Entry, MessageStore, load, names, save

__all__ = [
    "STANDARD",
    "ArchiveError",
    "Change",
    "Entry",
    "LocalMessages",
    "MessageLibrary",
    "MessageStore",
    "load",
    "names",
    "read_joint_states",
    "read_poses",
    "read_trajectories",
    "save",
]
