"""What a check or an import found: issues with a place, a stable code and, where there is one, a fix."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Literal

from .errors import InvalidTaskError

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True, slots=True)
class Issue:
    """One thing that is wrong, probably wrong, or to be known.

    Attributes:
        path: the node (`/` is the root), or the part of a file from elsewhere; empty for the task or file itself.
        code: stable word from `docs/validation_rules.md`.
        severity: an `error` can't be run or imported; a `warning` can; an `info` has only to be known.
        fix: what to do; empty where only a person can know.
        line: 1-based, None without a document.
        column: 1-based, None without a document.
        key: keys within the node that lead to it, such as `("in", "cloud")`; empty for the node as a whole.
    """

    path: str
    code: str
    severity: Severity
    message: str
    fix: str = ""
    line: int | None = None
    column: int | None = None
    source: str = ""
    key: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        place = self.source
        if self.line is not None:
            place = f"{place or '<text>'}:{self.line}" + (f":{self.column}" if self.column is not None else "")
        lead = f"{place}: " if place else ""
        end = "" if self.message.endswith("?") else "."
        fix = f" Fix: {self.fix}." if self.fix else ""
        return f"{lead}{self.severity}[{self.code}] {self.path or 'task'}: {self.message}{end}{fix}"

    def as_dict(self) -> dict[str, object]:
        """Return the issue as plain data, for JSON."""
        return asdict(self)


@dataclass(frozen=True, repr=False)
class Report:
    """All issues of a task, in the order of its text (without a document: of its nodes)."""

    issues: tuple[Issue, ...]

    def __repr__(self) -> str:
        return "\n".join(map(str, self.issues)) or "nothing is wrong"

    @property
    def errors(self) -> tuple[Issue, ...]:
        """What keeps the task from running."""
        return tuple(issue for issue in self.issues if issue.severity == "error")

    @property
    def warnings(self) -> tuple[Issue, ...]:
        """What is probably not meant."""
        return tuple(issue for issue in self.issues if issue.severity == "warning")

    @property
    def infos(self) -> tuple[Issue, ...]:
        """What has only to be known."""
        return tuple(issue for issue in self.issues if issue.severity == "info")

    @property
    def ok(self) -> bool:
        """Whether there are no errors."""
        return not self.errors

    def raise_if_invalid(self, source: str = "") -> None:
        """Raise InvalidTaskError with all errors if there are any."""
        if not self.ok:
            raise InvalidTaskError(self.errors, source)


def ordered(issues: Iterable[Issue]) -> Report:
    """Return a report with the issues in the order of the text."""
    return Report(tuple(sorted(issues, key=lambda i: (i.line or 0, i.column or 0))))
