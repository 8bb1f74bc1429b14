"""Edits of a task as values: applied to a task or to its text, each with an exact inverse, kept in a history.

`command` and the commands by subject -> `steps` on a `draft` -> the task; `text` applies steps to a text, of which
only the lines of the command change; `documents` reads typed text as a command; `history` with its file.
"""

from grip_bt.task.edit.editing import BaseCommand

from .change_kind import ChangeKind, Convert, Extract, Inline
from .commands import AnyCommand, Applied, Command, Group, Patch, apply, command_of, title_of
from .comment import Comment, comment_of
from .containers import Unwrap, Wrap
from .documents import Edited, apply_to_document, rewrite
from .history import History, Moment, history_path, load_history, save_history
from .keys import Connect, Disconnect, Set, SetMeaning, Unset
from .nodes import Add, Move, Remove, Rename
from .outcomes import RenameOutcome
from .paste import Clip, Paste, clip_of
from .steps import path_after
from .variables import Declare, RenameVariable, Undeclare

__all__ = [
    "Add",
    "AnyCommand",
    "Applied",
    "BaseCommand",
    "ChangeKind",
    "Clip",
    "Command",
    "Comment",
    "Connect",
    "Convert",
    "Declare",
    "Disconnect",
    "Edited",
    "Extract",
    "Group",
    "History",
    "Inline",
    "Moment",
    "Move",
    "Paste",
    "Patch",
    "Remove",
    "Rename",
    "RenameOutcome",
    "RenameVariable",
    "Set",
    "SetMeaning",
    "Undeclare",
    "Unset",
    "Unwrap",
    "Wrap",
    "apply",
    "apply_to_document",
    "clip_of",
    "comment_of",
    "command_of",
    "history_path",
    "load_history",
    "path_after",
    "rewrite",
    "save_history",
    "title_of",
]
