"""Named, typed stores: joint states, poses, grasps, clouds, anything that a project keeps by name.

    from grip_bt.base.message_store import MessageLibrary
    library = MessageLibrary("messages")          # the files of a project
    library.store("poses").get("bin")

The same over ROS 2, for other processes and languages: `grip_bt.ros.messages`.
"""

from .files import read_joint_states as read_joint_states
from .files import read_poses as read_poses
from .files import read_trajectories as read_trajectories
from .library import STANDARD as STANDARD
from .library import LocalMessages as LocalMessages
from .library import MessageLibrary as MessageLibrary
from .store import ArchiveError as ArchiveError
from .store import Change as Change
from .store import Entry as Entry
from .store import MessageStore as MessageStore
from .store import load as load
from .store import names as names
from .store import save as save
