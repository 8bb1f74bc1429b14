"""The root of the errors, words that their messages share, and the failures that any room may meet."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from functools import lru_cache
from typing import Any


def nearest(word: str, allowed: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for the closest allowed word, or an empty string."""
    return _nearest(word, tuple(allowed))


@lru_cache(maxsize=1024)
def _nearest(word: str, allowed: tuple[str, ...]) -> str:
    """As above, kept: one wrong name in each of 10,000 nodes is looked for once."""
    close = get_close_matches(word, allowed, n=1, cutoff=0.6)
    if word and not close:  # the last name of a path alone
        close = [path for path in allowed if path.endswith(f"/{word}")][:1]
    return f"; did you mean {close[0]!r}?" if close else ""


def listing(words: Iterable[str], nothing: str = "none") -> str:
    """Return the words joined by commas for an error message, or `nothing`."""
    return ", ".join(words) or nothing


class GripError(Exception):
    """Root of all errors that GRIP raises on purpose. They can be sent between processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Restore the attributes as they are: constructors ask for more than the message that `args` holds."""
        return _restored, (type(self), self.args, dict(self.__dict__))


def _restored(cls: type[GripError], args: tuple[Any, ...], attributes: dict[str, Any]) -> GripError:
    error = cls.__new__(cls, *args)
    error.__dict__.update(attributes)
    return error


class ExpectedError(GripError):
    """Trouble that a task should expect. `code` is the failure reason, `data` what may help to mend it."""

    code = "failed"

    def __init__(self, message: str, **data: Any):
        self.message, self.data = message, data
        super().__init__(message)


class CanceledError(ExpectedError):
    """An operation ended because it was cancelled."""

    code = "canceled"


class TimeOutError(ExpectedError):
    """An operation didn't end within its time."""

    code = "time_out"


class UnknownNameError(GripError):
    """A name was looked up that isn't there: a node type, an arm, a sensor, a component, a group ..."""

    def __init__(self, kind: str, name: str, allowed: Iterable[str], where: str = ""):
        self.kind, self.name, self.allowed, self.where = kind, name, tuple(sorted(allowed)), where
        at = f"{where}: " if where else ""
        unknown = f"unknown {kind} {name!r}{nearest(name, self.allowed)}" if name else f"which {kind}? None is named"
        super().__init__(f"{at}{unknown} (there are: {listing(self.allowed)})")


class AmbiguousNameError(UnknownNameError):
    """A beginning of a name that several have; `allowed` are those, in an order that helps."""

    def __init__(self, kind: str, name: str, allowed: Sequence[str], where: str = "", most: int = 8):
        super().__init__(kind, name, allowed, where)
        more = ", ..." if len(allowed) > most else ""
        at = f"{where}: " if where else ""
        self.args = (
            f"{at}{len(allowed)} {kind}s begin with {name!r}: {', '.join(allowed[:most])}{more}; give more of it",
        )


class MissingPartError(GripError):
    """Something that this command needs isn't installed; `remedy` is the command that mends it."""

    def __init__(self, what: str, remedy: str):
        self.what, self.remedy = what, remedy
        super().__init__(f"{what} isn't available here. To mend it: {remedy}")
