"""A part of a task as a file of its own, and back: edits that know the project's nodes and files."""

from __future__ import annotations

from grip_bt.compilers.restructure import expanded, extracted
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document
from grip_bt.task.edit import AnyCommand, Convert, Extract, Group, Inline

from .desk import EditDesk
from .sheet import Sheet


def takes_catalogue(command: AnyCommand) -> bool:
    """Tell whether a command, or one of its parts, can be carried out only by who knows the project's nodes."""
    if isinstance(command, Group):
        return any(takes_catalogue(part) for part in command.commands)
    return isinstance(command, Convert | Extract | Inline)


def carry_out(desk: EditDesk, sheet: Sheet, command: AnyCommand, base: int, catalog: Catalog) -> None:
    """Carry out a command that takes a catalogue; an `extract` makes its file, which stays where the edit is undone.

    Raises:
        EditError: it can't be carried out.
        HandoverError: it can, but somebody could tell; `approximate` does it all the same.
        DocumentError: the new file is there already, or can't be written.
        OutsideProjectError: the new file isn't one of a task of the project.
        StaleEditError: what it is about is gone since `base`.
    """

    def meant(now: AnyCommand, document: Document) -> AnyCommand:
        if not isinstance(now, Extract):
            return expanded(now, document.task, catalog)
        part = extracted(now, document, catalog)
        desk.create(part.file, part.text)
        return part.edit

    sheet.do(command, base, meant)
