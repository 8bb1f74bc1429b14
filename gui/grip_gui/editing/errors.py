"""Why an edit, or a save, isn't done: somebody else was faster, or the text isn't a task yet."""

from __future__ import annotations

from grip_bt.base.errors import GripError


class StaleEditError(GripError):
    """An edit was made on an older state, and what it is about has changed since."""


class UnfinishedTextError(GripError):
    """A drawn edit was asked for while the text isn't a task."""

    def __init__(self, path: str, why: str):
        super().__init__(
            f"{path}: the text isn't a task at the moment ({why}); mend it in the text view, or undo to drop it"
        )


class ChangedOnDiskError(GripError):
    """The file was changed by somebody else since it was opened or saved."""

    def __init__(self, path: str, how: str):
        super().__init__(
            f"{path} was {how} outside the editor since it was opened here; take the file's text (undo brings yours "
            "back), or save yours over it"
        )
