"""Errors of task documents: reading, editing and evaluating them."""

from __future__ import annotations

from .base import GripError


class DocumentError(GripError):
    """A file can't be read as a task, a project or a manifest.

    Attributes:
        source: the file's name as the user gave it.
        line: 1-based line, or None.
        column: 1-based column, or None.
    """

    def __init__(self, message: str, source: str = "", line: int | None = None, column: int | None = None):
        self.message, self.source, self.line, self.column = message, source, line, column
        place = source or "<text>"
        if line is not None:
            place += f":{line}" + (f":{column}" if column is not None else "")
        super().__init__(f"{place}: {message}")


class ExpressionError(GripError):
    """A text isn't an expression of the language of guards and switches.

    Attributes:
        text: the expression.
        message: what is wrong and what is allowed.
        column: 1-based column within the expression.
    """

    def __init__(self, text: str, message: str, column: int = 1):
        self.text, self.message, self.column = text, message, column
        super().__init__(f"`{text}`, column {column}: {message}")


class EvaluationError(GripError):
    """An expression can't be computed with the values that its variables have; a bug of the task."""

    def __init__(self, text: str, message: str):
        self.text, self.message = text, message
        super().__init__(f"`{text}`: {message}")


class EditError(GripError):
    """An edit that can't be made; the task is as it was.

    Attributes:
        path: the node, or the place in the file, that the edit is about.
        message: what is wrong and what to do.
    """

    def __init__(self, path: str, message: str):
        self.path, self.message = path, message
        super().__init__(f"{path or 'the task'}: {message}")


class HandoverError(EditError):
    """A part and a subtask can't take each other's place unseen: values go in and out of a subtask all at once.

    Who wants it all the same says `approximate: true`.
    """


class SubtaskError(GripError):
    """A file can't be run as a subtask.

    Attributes:
        file: its name, as `task:` of the subtask has it.
        reason: why, and what to do.
    """

    def __init__(self, file: str, reason: str):
        self.file, self.reason = file, reason
        super().__init__(f"subtask {file!r}: {reason}")
