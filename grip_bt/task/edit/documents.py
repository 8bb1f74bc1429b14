"""Commands applied to documents: the text changes only where the command does, and the inverse gives the bytes back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from hashlib import blake2b

from grip_bt.base.errors import DocumentError, EditError

from ..document import Document, read_text
from ..model import Task
from .alike import alike, said_alike
from .commands import AnyCommand, Patch, Restore, Splice, apply
from .steps import Assign, Put, Remark, Step, path_after
from .text import Text


@dataclass(frozen=True)
class Edited:
    """A document after a command.

    Attributes:
        document: the new document.
        inverse: the command that leads back; on this document's text to the very bytes that were there before.
        steps: what was done, for whatever else follows the edit.
        splices: what changed in the text, one after the other.
    """

    document: Document
    inverse: Patch
    steps: tuple[Step, ...]
    splices: tuple[Splice, ...]

    def path(self, before: str) -> str | None:
        """Return where the node that was at a path is now; None when it is gone."""
        return path_after(before, self.steps)


def apply_to_document(document: Document, command: AnyCommand) -> Edited:
    """Return a document after a command; comments, and the formatting of everything else, stay.

    Raises:
        EditError: the command can't be carried out, or the text is spelled in a way that can't be changed in place;
            nothing has changed.
    """
    done = apply(document.task, command)
    if isinstance(command, Patch) and command.restore and command.restore.digest == digest_of(document.text):
        text, splices, sources = _restored(document.text, command.restore), command.restore.splices, {}
    else:
        draft = Text(document.text, document.tree)
        taken = [draft.take(step) for step in done.steps]
        draft.flush()
        text, splices = draft.text, tuple(draft.splices)
        sources = {len(taken) - 1 - number: source for number, source in enumerate(taken) if source}
    after = _read(text, document.source, done.task)
    back = tuple(Splice(start=s.start, old=s.new, new=s.old) for s in reversed(splices))
    inverse = Patch(
        title=done.inverse.title,
        steps=tuple(_with_source(step, sources.get(n)) for n, step in enumerate(done.inverse.steps)),
        restore=Restore(digest=digest_of(text), splices=back),
    )
    return Edited(after, inverse, done.steps, splices)


def _read(text: str, source: str, expected: Task) -> Document:
    """Read an edited text, and make sure that it says what the edited task says."""
    try:
        after = read_text(text, source)
    except DocumentError as error:
        raise EditError("", f"can't be written here ({error.message}); run `grip fmt` and edit again") from error
    if not alike(after.task, expected):
        raise EditError("", "this spelling can't be edited in place; run `grip fmt` and edit again")
    # The edited task shares with the one before all that the edit left alone, so that others see fast what is new.
    return replace(after, task=expected) if said_alike(after.task, expected) else after


def _restored(text: str, restore: Restore) -> str:
    for splice in restore.splices:
        text = text[: splice.start] + splice.new + text[splice.start + len(splice.old) :]
    return text


def _with_source(step: Step, source: str | None) -> Step:
    if source is not None and isinstance(step, Remark):
        return step.model_copy(update={"text": source})
    if source is not None and isinstance(step, Put | Assign):
        return step.model_copy(update={"source": source})
    return step


def digest_of(text: str) -> str:
    """Return what tells whether a text is still the one that an inverse was made for."""
    return blake2b(text.encode(errors="surrogatepass"), digest_size=16).hexdigest()
