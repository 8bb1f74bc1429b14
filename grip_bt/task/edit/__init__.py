"""Edits of a task as values: applied to a task or to its text, each with an exact inverse, kept in a history.

`command` and the commands by subject -> `steps` on a `Draft` -> the task; `text` applies steps to a text, of which
only the lines of the command change; `documents` reads typed text as a command; `history` with its file.
"""

from .change_kind import ChangeKind as ChangeKind
from .change_kind import Convert as Convert
from .change_kind import Extract as Extract
from .commands import AnyCommand as AnyCommand
from .commands import Group as Group
from .commands import Patch as Patch
from .commands import apply as apply
from .commands import command_of as command_of
from .commands import title_of as title_of
from .comment import Comment as Comment
from .comment import comment_of as comment_of
from .containers import Unwrap as Unwrap
from .containers import Wrap as Wrap
from .documents import apply_to_document as apply_to_document
from .documents import rewrite as rewrite
from .history import History as History
from .history import history_path as history_path
from .history import load_history as load_history
from .history import save_history as save_history
from .keys import Connect as Connect
from .keys import Disconnect as Disconnect
from .keys import Set as Set
from .keys import SetMeaning as SetMeaning
from .keys import Unset as Unset
from .nodes import Add as Add
from .nodes import Move as Move
from .nodes import Remove as Remove
from .nodes import Rename as Rename
from .outcomes import RenameOutcome as RenameOutcome
from .paste import Paste as Paste
from .paste import clip_of as clip_of
from .steps import path_after as path_after
from .variables import Declare as Declare
from .variables import RenameVariable as RenameVariable
from .variables import Undeclare as Undeclare
